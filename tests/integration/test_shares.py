# SPDX-License-Identifier: BSD-3-Clause
"""Jobs that sample the points of one deck into one results folder: --share K/N, as in an array of jobs."""

import re
import signal

import numpy as np
import pytest

import test_friction
import test_history
from program import finish, kill, wait_until
from results import read_snapshots
from runs import refuse, write_deck

# Format of a shard: header with four sizes (parameters, dofs, multipliers, further values), then records of 8-byte
# numbers with a checksum.
HEADER, SIZES = 72, slice(32, 64)
# half of them take longer than the second after which records are written
N_SWEEP = 12000  # a half takes longer than the second after which records are flushed


def read_shard(path):
    """The points of the whole records of a shard: an array of shape (n_records, n_parameters)."""
    content = path.read_bytes()
    sizes = np.frombuffer(content[SIZES], dtype=np.int64)
    n_numbers = sizes.sum() + 1
    body = content[HEADER:]
    records = np.frombuffer(body[: len(body) // (8 * n_numbers) * 8 * n_numbers]).reshape(-1, n_numbers)
    return records[:, : sizes[0]]


def points_of_shares(results, n_shares, store="snapshots"):
    """The points in the shards of each share."""
    return [
        np.vstack([read_shard(path) for path in sorted(results.glob(f"{store}.part-{k}of{n_shares}.*"))])
        for k in range(1, n_shares + 1)
    ]


def check_sorted_once(shares, expected):
    """All shares together have each expected point once."""
    found, wanted = ([tuple(point) for point in points] for points in (np.vstack(shares), expected))
    assert len(found) == len(wanted)
    assert sorted(found) == sorted(wanted)


def check_same(found, expected):
    """Snapshots of shares are those of one job, up to rounding: both solve the same systems."""
    for name in ("parameters", "reasons"):
        np.testing.assert_array_equal(found[name], expected[name])
    for name in ("displacement", "multipliers", "free_response"):
        scale = np.abs(expected[name]).max(initial=0)
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=1e-12 * scale)


def write_sweep(folder, n_points=N_SWEEP):
    """A deck whose points take a second or more, and its results folder."""
    changes = {
        "grid: {push: 5}": f"grid: {{push: {n_points}}}",
        "title: ": "solver: {type: active_set}\ntitle: ",
    }
    return write_deck("patch", folder, **changes), folder / "results" / "patch"


def start_share(signorom, deck, share, **options):
    """The started command."""
    return signorom.start("sample", deck.name, "--share", share, folder=deck.parent, **options)


@pytest.fixture(scope="module")
def one_job(signorom, tmp_path_factory):
    """Snapshots of write_sweep from one job."""
    deck, results = write_sweep(tmp_path_factory.mktemp("one_job"))
    signorom("sample", deck.name, folder=deck.parent)
    return read_snapshots(results / "snapshots.h5")


def test_jobs_at_the_same_time(signorom, tmp_path, one_job):
    """Two jobs, one of them with two groups of ranks; the other one is killed and started again."""
    deck, results = write_sweep(tmp_path)
    victim = start_share(signorom, deck, "1/2")
    shard = results / "snapshots.part-1of2.1"
    wait_until(lambda: shard.exists() and len(read_shard(shard)) > 0, victim)
    kill(victim)
    n_kept = len(read_shard(shard))
    assert n_kept < N_SWEEP // 2
    jobs = [start_share(signorom, deck, f"{k}/2", n_ranks=k) for k in (1, 2)]
    said = [finish(job) for job in jobs]
    assert [done.returncode for done in said] == [0, 0], [done.stderr for done in said]
    assert (
        f"sampled {N_SWEEP // 2} points ({n_kept} were there): share 1/2 in results/patch" in said[0].stdout
    )
    shares = points_of_shares(results, 2)
    assert [len(points) for points in shares] == [N_SWEEP // 2] * 2
    check_sorted_once(shares, one_job["parameters"])
    assert not (results / "snapshots.h5").exists()
    done = signorom.run("sample", deck.name, folder=tmp_path)
    assert f"sampled {N_SWEEP} points ({N_SWEEP} were there)" in done.stdout
    assert done.stderr == ""
    assert list(results.glob("snapshots.part-*")) == []
    check_same(read_snapshots(results / "snapshots.h5"), one_job)
    signorom("train", deck.name, folder=tmp_path)
    # a job of the array that comes late finds its points in the merged file
    late = signorom("sample", deck.name, "--share", "1/2", folder=tmp_path)
    assert f"sampled {N_SWEEP // 2} points ({N_SWEEP // 2} were there): share 1/2" in late
    assert list(results.glob("snapshots.part-*")) == []


def test_missing_shares_are_named(signorom, tmp_path):
    """Training says what there is; a sampling of all points says what it has to solve, and solves it."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, "--share", "2/3", folder=tmp_path)
    words = refuse(signorom, "train", deck.name, folder=tmp_path)
    assert re.match(r"results/patch/snapshots.h5: error: there are no snapshots yet, .* share 2/3\n", words)
    done = signorom.run("sample", deck.name, folder=tmp_path)
    assert done.returncode == 0
    lacking = "these shares lack points, which this run solves now: 1/3 (2 of 2 points), 3/3 (1 of 1 point)"
    assert f"warning: {lacking}\n" in done.stderr
    assert "sampled 5 points (2 were there)" in done.stdout
    assert "warning" not in signorom.run("sample", deck.name, folder=tmp_path).stderr


def test_more_shares_than_points(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    said = signorom("sample", deck.name, "--share", "6/6", folder=tmp_path)
    assert "sampled 0 points (0 were there): share 6/6" in said
    assert not list((tmp_path / "results" / "patch").glob("snapshots*"))


def test_same_share_twice(signorom, tmp_path, one_job):
    """The second leaves at once; so does a run of the whole deck. Another share may run."""
    deck, results = write_sweep(tmp_path)
    first = start_share(signorom, deck, "1/2")
    try:
        wait_until(lambda: any(results.glob("snapshots.part-*")), first)
        first.send_signal(signal.SIGSTOP)
        twice = signorom.run("sample", deck.name, "--share", "1/2", folder=tmp_path, time_limit=30)
        whole = signorom.run("run", deck.name, folder=tmp_path, n_ranks=2, time_limit=30)
        other = signorom.run("sample", deck.name, "--share", "2/2", folder=tmp_path)
        first.send_signal(signal.SIGCONT)
    except BaseException:
        kill(first)
        raise
    assert twice.returncode == 2
    assert re.match(
        rf"results/patch: error: another run writes the same share .* \(process {first.pid}\)", twice.stderr
    )
    assert whole.returncode == 2
    assert re.match(r"results/patch: error: another run writes into this folder now\n", whole.stderr)
    assert other.returncode == 0, other.stderr
    assert finish(first).returncode == 0
    check_sorted_once(points_of_shares(results, 2), one_job["parameters"])


def test_share_beside_a_run_of_all_points(signorom, tmp_path):
    deck, results = write_sweep(tmp_path)
    whole = signorom.start("sample", deck.name, folder=tmp_path)
    try:
        wait_until(lambda: any(results.glob("snapshots.part-*")), whole)
        whole.send_signal(signal.SIGSTOP)
        share = signorom.run("sample", deck.name, "--share", "1/2", folder=tmp_path, time_limit=30)
    finally:
        kill(whole)
    assert share.returncode == 2
    assert re.match(
        rf"results/patch: error: another run writes into this folder now \(process {whole.pid}\)",
        share.stderr,
    )


def test_share_uses_points_of_a_run_of_all(signorom, tmp_path, one_job):
    """A run that was killed becomes an array of jobs."""
    deck, results = write_sweep(tmp_path)
    whole = signorom.start("sample", deck.name, folder=tmp_path)
    shard = results / "snapshots.part-1"
    wait_until(lambda: shard.exists() and len(read_shard(shard)) > 10, whole)
    kill(whole)
    kept = {tuple(point) for point in read_shard(shard)}
    n_own = sum(tuple(point) in kept for point in one_job["parameters"][0::2])
    said = signorom("sample", deck.name, "--share", "1/2", folder=tmp_path)
    assert f"sampled {N_SWEEP // 2} points ({n_own} were there)" in said
    (own,) = results.glob("snapshots.part-1of2.*")
    assert len(read_shard(own)) == N_SWEEP // 2 - n_own


def test_deck_that_changes_between_jobs(signorom, tmp_path):
    """A share of another deck is refused before anything is solved, although it would write a file of its own."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, "--share", "1/2", folder=tmp_path)
    text = deck.read_text()
    deck.write_text(text.replace("young_modulus: 2.0e6", "young_modulus: 2.1e6"))
    words = refuse(signorom, "sample", deck.name, "--share", "2/2", folder=tmp_path, n_ranks=2)
    assert re.match(r"results/patch/snapshots.part-1of2.1: error: .* another deck, mesh or field file", words)
    # without displacements: other sizes
    deck.write_text(text.replace("{method: hhr}", "{method: condensed}"))
    words = refuse(signorom, "sample", deck.name, "--share", "2/2", folder=tmp_path)
    assert re.match(r"results/patch/snapshots.part-1of2.1: error: .* other numbers of parameters", words)


def test_another_number_of_shares(signorom, tmp_path):
    """It would solve points twice; after a merge it may begin."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, "--share", "1/2", folder=tmp_path)
    words = refuse(signorom, "sample", deck.name, "--share", "1/3", folder=tmp_path)
    assert words.startswith(
        "results/patch/snapshots.part-1of2.1: error: here are points of share 1/2, which do not go with share 1/3"
    )
    signorom("sample", deck.name, folder=tmp_path)
    assert "(2 were there)" in signorom("sample", deck.name, "--share", "1/3", folder=tmp_path)


def test_greedy_selection_has_no_shares(signorom, tmp_path):
    deck = write_deck(
        "patch",
        tmp_path,
        **{
            "training: {grid: {push: 5}}": "training: {greedy: {candidates: {grid: {push: 9}}, max_points: 5}}"
        },
    )
    words = refuse(signorom, "sample", deck.name, "--share", "1/2", folder=tmp_path)
    assert re.match(r"patch.yaml:13:\d+: error: --share does not go with training.greedy", words)


def test_bad_point_of_another_share(signorom, tmp_path):
    """Each job looks at all points: here the gap of the last one is not defined."""
    deck = write_deck(
        "patch", tmp_path, **{"direction: [0, 1]}": 'direction: [0, 1], initial_gap: "0.01 / (0.1 - push)"}'}
    )
    messages = [
        refuse(signorom, "sample", deck.name, "--share", share, folder=tmp_path) for share in ("1/2", "2/2")
    ]
    assert messages[0] == messages[1]
    assert "push = 0.1" in messages[0]


@pytest.mark.parametrize("study", [test_history, test_friction])
def test_whole_histories(signorom, tmp_path, study):
    """A share has all times of its points; with friction they depend on each other."""
    n_times = len(study.TIMES)
    one, many = study.write_deck(tmp_path / "one"), study.write_deck(tmp_path / "many")
    signorom("sample", one.name, folder=one.parent)
    expected = read_snapshots(one.parent / "results" / "part" / "snapshots.h5")
    for share in ("2/3", "1/3", "3/3"):
        signorom("sample", many.name, "--share", share, folder=many.parent)
    results = many.parent / "results" / "part"
    shares = points_of_shares(results, 3)
    check_sorted_once(shares, expected["parameters"])
    for points in shares:
        assert len(points) % n_times == 0
        _, counts = np.unique(points[:, :2], axis=0, return_counts=True)
        assert (counts == n_times).all()
    signorom("sample", many.name, folder=many.parent)
    check_same(read_snapshots(results / "snapshots.h5"), expected)


def test_stiffnesses_are_not_shared(signorom, tmp_path):
    """Points with the same elastic constants go to one job, so that each is factored once."""
    changes = {
        "parameters: {push: {min: 0.02, max: 0.1, unit: m}}": "parameters: {push: {min: 0.02, max: 0.1}, "
        "E: {min: 1.0e6, max: 3.0e6}}",
        "young_modulus: 2.0e6": "young_modulus: E",
        "training: {grid: {push: 5}}": "training: {grid: {push: 3, E: 4}, stiffness: factored}",
        "test: {grid: {push: 7}}\n": "",
        "points: [{push: 0.05}]": "points: [{push: 0.05, E: 2.0e6}]",
    }
    deck = write_deck("patch", tmp_path, **changes)
    for share in ("1/2", "2/2"):
        said = signorom("sample", deck.name, "--share", share, folder=tmp_path)
        assert "sampled 6 points (0 were there, 2 stiffnesses)" in said
    shares = points_of_shares(tmp_path / "results" / "patch", 2)
    assert not {*shares[0][:, 1]} & {*shares[1][:, 1]}


def test_candidates_have_shares(signorom, tmp_path):
    """The candidates of local models up to a target, too."""
    changes = {
        "reduction: {method: hhr, pod_tolerance: 1.0e-5}": "clusters: {number: auto, target: {error: 0.1, "
        "measure: e_lambda_rid, candidates: {sobol: 9}}}\nreduction: {method: hhr, pod_tolerance: 1.0e-5}",
    }
    deck = write_deck("shifted_disks", tmp_path, **changes)
    for share in ("1/2", "2/2"):
        signorom("sample", deck.name, "--share", share, folder=tmp_path)
    shares = points_of_shares(tmp_path / "results" / "shifted_disks", 2, "candidates")
    assert [len(points) for points in shares] == [5, 4]
    said = signorom("sample", deck.name, folder=tmp_path)
    assert "solved 9 candidates (9 were there)" in said
