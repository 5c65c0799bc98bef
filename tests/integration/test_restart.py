# SPDX-License-Identifier: BSD-3-Clause
"""Runs that are killed, stopped, damaged, hindered or started twice."""

import os
import re
import resource
import shutil
import signal

import h5py
import numpy as np
import pytest

from program import finish, is_sanitized, kill, mpi_needs_large_files, wait_until
from results import read_snapshots
from runs import HERE, files_in, on_ranks, refuse, write_deck

pytestmark = pytest.mark.slow

N_POINTS = 6000  # they take longer than the second after which records are flushed
# Format of a shard: header, then records of 8-byte numbers (1 parameter, 116 dofs, 5 multipliers, 5 residuals, seconds,
# iterations, reason) with a checksum.
HEADER = 72
NUMBERS = 1 + 116 + 5 + 8 + 1
RECORD = 8 * NUMBERS


def write_points(deck, n_points, n_all=N_POINTS):
    """Let the deck ask for the first of all points of the sweep."""
    points = np.linspace(0.02, 0.1, n_all)[:n_points].tolist()
    (deck.parent / "points.csv").write_text("\n".join(["push", *map(repr, points), ""]))


def write_sweep(folder, n_points=N_POINTS):
    """A deck that takes seconds for all points, and its results folder."""
    changes = {"grid: {push: 5}": "file: points.csv", "title: ": "solver: {type: active_set}\ntitle: "}
    deck = write_deck("patch", folder, **changes)
    write_points(deck, n_points, n_points)
    return deck, folder / "results" / "patch"


@pytest.fixture
def many_points(tmp_path):
    """The deck and the folder of write_sweep."""
    return write_sweep(tmp_path)


@pytest.fixture(scope="module")
def uninterrupted(signorom, tmp_path_factory):
    """Snapshots of a run that nothing disturbs."""
    deck, results = write_sweep(tmp_path_factory.mktemp("uninterrupted"))
    signorom("sample", deck.name, folder=deck.parent)
    return read_snapshots(results / "snapshots.h5")


def shards(results):
    """Shard files in a results folder."""
    return sorted(results.glob("snapshots.part-*"))


def n_records(results):
    """Whole records in all shards."""
    return sum(max(0, shard.stat().st_size - HEADER) // RECORD for shard in shards(results))


def last_point(results):
    """The number, from 1, of the last point of the sweep that has a record."""
    pushes = []
    for path in shards(results):
        content = path.read_bytes()[HEADER:]
        records = np.frombuffer(content[: len(content) // RECORD * RECORD]).reshape(-1, NUMBERS)
        pushes.append(records[:, 0])
    return 1 + round((np.concatenate(pushes).max() - 0.02) / 0.08 * (N_POINTS - 1))


@pytest.fixture(scope="module")
def killed_runs(signorom, tmp_path_factory):
    """For one rank and for two groups, what SIGKILL leaves when a tenth of the points is there."""
    folders = {}
    for n_ranks in (1, 2):
        deck, results = write_sweep(tmp_path_factory.mktemp("killed"))
        process = signorom.start("sample", deck.name, folder=deck.parent, n_ranks=n_ranks)
        wait_until(lambda results=results: n_records(results) > N_POINTS / 10, process)
        kill(process)
        folders[n_ranks] = deck.parent
    return folders


@pytest.fixture
def killed(killed_runs, tmp_path):
    """A function of the number of ranks: the deck and the results of a copy of a killed run."""

    def copy(n_ranks):
        folder = shutil.copytree(killed_runs[n_ranks], tmp_path / "killed")
        return folder / "patch.yaml", folder / "results" / "patch"

    return copy


def resume(signorom, deck, results, n_ranks, uninterrupted, n_points):
    """Run the same command again for the first points: how many it found, after a comparison with an undisturbed run."""
    write_points(deck, n_points)
    output = signorom("sample", deck.name, folder=deck.parent, n_ranks=n_ranks)
    found = int(re.search(rf"sampled {n_points} points \((\d+) were there\)", output).group(1))
    assert f"sampling: {n_points - found} of {n_points - found} in " in output
    assert shards(results) == []
    snapshots = read_snapshots(results / "snapshots.h5")
    for name in ("parameters", "reasons"):
        np.testing.assert_array_equal(snapshots[name], uninterrupted[name][:n_points])
    for name in ("displacement", "multipliers", "free_response"):
        scale = np.abs(uninterrupted[name]).max()
        np.testing.assert_allclose(
            snapshots[name], uninterrupted[name][:n_points], rtol=0, atol=1e-13 * scale
        )
    return found


def resume_for_a_while(signorom, deck, results, n_ranks, uninterrupted):
    """As resume, for the points up to the last finished one and a hundred more: the others would say the same again."""
    n_points = min(last_point(results) + 100, N_POINTS)
    return resume(signorom, deck, results, n_ranks, uninterrupted, n_points)


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_kill_and_resume(signorom, killed, uninterrupted, n_ranks):
    """SIGKILL in the middle, with one rank and with two groups: every finished point is there afterwards."""
    deck, results = killed(n_ranks)
    finished = n_records(results)
    assert len(shards(results)) == n_ranks
    assert N_POINTS / 10 < finished < N_POINTS
    assert not (results / "snapshots.h5").exists()
    assert resume(signorom, deck, results, n_ranks, uninterrupted, N_POINTS) == finished


def test_resume_on_another_rank_count(signorom, killed, uninterrupted):
    deck, results = killed(2)
    finished = n_records(results)
    assert resume_for_a_while(signorom, deck, results, 1, uninterrupted) == finished


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_after_the_current_point(signorom, many_points, uninterrupted, number):
    deck, results = many_points
    process = signorom.start("run", deck.name, folder=deck.parent)
    wait_until(lambda: n_records(results) > N_POINTS / 10, process)
    process.send_signal(number)
    done = finish(process, 30)
    assert done.returncode == 130
    assert "run the same command again to go on" in done.stdout
    assert done.stderr == ""
    finished = n_records(results)
    assert (shards(results)[0].stat().st_size - HEADER) % RECORD == 0
    assert N_POINTS / 10 < finished < N_POINTS
    assert resume_for_a_while(signorom, deck, results, 1, uninterrupted) == finished


@pytest.mark.usefixtures("patient_mpirun")
def test_signal_to_mpirun(signorom, tmp_path):
    """mpirun ends all ranks in its own way, and takes a second for it; the finished points stay."""
    n_points = 20000
    deck, results = write_sweep(tmp_path, n_points)
    process = signorom.start("sample", deck.name, folder=tmp_path, n_ranks=2)
    wait_until(lambda: n_records(results) > 0, process)
    process.send_signal(signal.SIGINT)
    done = finish(process, 30)
    assert done.returncode != 0
    assert not (results / "snapshots.h5").exists()
    finished = n_records(results)
    assert 0 < finished < n_points
    write_points(deck, 5)
    assert "sampled 5 points (" in signorom("sample", deck.name, folder=tmp_path)


def test_signal_ends_the_fields(signorom, tmp_path):
    """After the current point, and without half a file."""
    points = ", ".join(f"{{push: {0.02 + 0.00005 * i:.5f}}}" for i in range(1500))
    changes = {
        "points: [{push: 0.05}]": f"points: [{points}]",
        "title: ": "solver: {type: active_set}\ntitle: ",
    }
    deck, results = write_deck("patch", tmp_path, **changes), tmp_path / "results" / "patch"
    process = signorom.start("solve", deck.name, folder=tmp_path)
    wait_until(lambda: (results / ".lock").exists(), process)
    process.send_signal(signal.SIGINT)
    done = finish(process, 30)
    assert done.returncode == 130
    # with sanitizers a point may take longer than the second after which the process ends by itself
    words = (
        "stopped by a signal"
        if is_sanitized(signorom.executable)
        else "stopped by a signal; no fields were written"
    )
    assert words in done.stdout
    assert done.stderr == ""
    assert list(files_in(results)) == []


def test_signal_ends_a_run_between_its_stages(signorom, tmp_path):
    """Snapshots are there, so training is what the signal meets; validation does not begin."""
    changes = {"grid: {push: 5}": "grid: {push: 3000}", "grid: {push: 7}": "grid: {push: 100000}"}
    deck, results = write_deck("patch", tmp_path, **changes), tmp_path / "results" / "patch"
    signorom("sample", deck.name, folder=tmp_path)
    (results / ".lock").unlink(missing_ok=True)
    process = signorom.start("run", deck.name, folder=tmp_path)
    wait_until(lambda: (results / ".lock").exists(), process)
    process.send_signal(signal.SIGTERM)
    done = finish(process, 30)
    assert done.returncode == 130
    assert "stopped by a signal" in done.stdout
    assert not (results / "validation.csv").exists()


def test_unused_option_is_found_after_the_first_point(signorom, many_points):
    """Not after hours of work."""
    deck, results = many_points
    done = signorom.run("sample", deck.name, "-active_set_nonsense", 1, folder=deck.parent)
    assert done.returncode == 2
    assert done.stderr.startswith("error: the PETSc option -active_set_nonsense was not used")
    assert n_records(results) == 1


def test_options_of_a_solver_with_nothing_to_do(signorom, tmp_path):
    """They are right also where all points are there, and on a rank that gets no point."""
    changes = {
        "reduction: {method: hhr}": "solver: {type: active_set}\nreduction: {method: hhr}\n"
        "petsc_options: -active_set_mat_mumps_icntl_14 40",
        "grid: {push: 5}": "grid: {push: 2}",
    }
    deck = write_deck("patch", tmp_path, **changes)
    for words in ("(0 were there)", "(2 were there)"):
        assert words in signorom("sample", deck.name, folder=tmp_path)
    deck.write_text(deck.read_text().replace("grid: {push: 2}", "grid: {push: 3}"))
    assert "sampled 3 points (2 were there)" in signorom("sample", deck.name, folder=tmp_path, n_ranks=2)


def test_second_run_does_nothing(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, folder=tmp_path)
    before = files_in(tmp_path)
    assert "sampled 5 points (5 were there)" in signorom("sample", deck.name, folder=tmp_path)
    assert files_in(tmp_path) == before


def test_more_points_of_the_same_study(signorom, tmp_path):
    """A finer grid uses the points that are there: 5 of 9."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, folder=tmp_path)
    deck.write_text(deck.read_text().replace("grid: {push: 5}", "grid: {push: 9}"))
    assert "sampled 9 points (5 were there)" in signorom("sample", deck.name, folder=tmp_path)
    snapshots = read_snapshots(tmp_path / "results" / "patch" / "snapshots.h5")
    np.testing.assert_allclose(snapshots["parameters"][:, 0], np.linspace(0.02, 0.1, 9), rtol=1e-14)


@pytest.mark.parametrize("n_ranks", [1, 2])
def test_truncated_shard(signorom, killed, uninterrupted, n_ranks):
    """Half a record at the end, as after a power cut, costs that record and a warning."""
    deck, results = killed(n_ranks)
    # the one with most records: the ranks may be far apart
    shard = max(shards(results), key=lambda path: path.stat().st_size)
    n_good = (shard.stat().st_size - HEADER) // RECORD - 3
    os.truncate(shard, HEADER + n_good * RECORD + RECORD // 2)
    finished = n_records(results)
    done = signorom.run("train", deck.name, folder=deck.parent)
    assert done.returncode == 2
    assert "no snapshots yet" in done.stderr
    assert resume_for_a_while(signorom, deck, results, n_ranks, uninterrupted) == finished


@pytest.mark.parametrize("number", [1, 2])
def test_damaged_record_is_named(signorom, killed, number):
    """A flipped bit is found by the checksum; what stands behind it is solved again. It is told once, also of a shard
    that the run does not write to: with one rank there is only one group.
    """
    deck, results = killed(1)
    content = bytearray(shards(results)[0].read_bytes())
    content[HEADER + 50 * RECORD + 100] ^= 1
    shards(results)[0].unlink()
    (results / f"snapshots.part-{number}").write_bytes(content)
    write_points(deck, 200)
    done = signorom.run("sample", deck.name, folder=deck.parent)
    assert done.returncode == 0
    assert len(re.findall(rf"warning: .*snapshots.part-{number}.* damaged", done.stderr)) == 1
    assert "sampled 200 points (50 were there)" in done.stdout


def test_shard_of_another_deck_is_refused(signorom, many_points):
    deck, results = many_points
    process = signorom.start("sample", deck.name, folder=deck.parent)
    wait_until(lambda: n_records(results) > 10, process)
    kill(process)
    deck.write_text(deck.read_text().replace("poisson_ratio: 0", "poisson_ratio: 0.1"))
    words = refuse(signorom, "sample", deck.name, folder=deck.parent)
    assert re.search(r"results/patch/snapshots.part-1: error: .* another deck, mesh or field file", words)


@pytest.mark.parametrize(("command", "n_ranks"), on_ranks([("sample",), ("train",), ("run",)]))
def test_snapshots_of_another_deck_are_refused(signorom, tmp_path, command, n_ranks):
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, folder=tmp_path)
    deck.write_text(deck.read_text().replace("young_modulus: 2.0e6", "young_modulus: 2.1e6"))
    words = refuse(signorom, command, deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert re.match(r"results/patch/snapshots.h5: error: .* another deck, mesh or field file", words)


def test_snapshots_of_another_mesh_are_refused(signorom, tmp_path):
    """The same deck, the same file name, other content."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "decks").mkdir()
    deck = tmp_path / "decks" / "patch.yaml"
    deck.write_text((HERE / "decks" / "patch.yaml").read_text())
    mesh = tmp_path / "meshes" / "two_blocks.msh"
    mesh.write_bytes((HERE / "meshes" / "two_blocks.msh").read_bytes())
    signorom("sample", deck, folder=tmp_path)
    mesh.write_bytes((HERE / "meshes" / "two_blocks_v22_ascii.msh").read_bytes())
    words = refuse(signorom, "sample", deck, folder=tmp_path)
    assert re.match(r"results/patch/snapshots.h5: error: .* another deck, mesh or field file", words)


def test_what_does_not_change_the_answers_keeps_the_snapshots(signorom, tmp_path):
    """Title, points and reduction are no part of the physics."""
    deck = write_deck("patch", tmp_path)
    signorom("sample", deck.name, folder=tmp_path)
    text = (
        deck.read_text()
        .replace("Contact patch test", "Another title")
        .replace("{method: hhr}", "{method: hhr, pod_tolerance: 1.0e-4}")
        .replace("grid: {push: 7}", "grid: {push: 3}")
    )
    deck.write_text(text)
    assert "(5 were there)" in signorom("run", deck.name, folder=tmp_path)


def test_file_that_is_no_snapshots(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    results = tmp_path / "results" / "patch"
    results.mkdir(parents=True)
    for content in (b"", b"some text\n", b"\x89HDF\r\n\x1a\n"):
        (results / "snapshots.h5").write_bytes(content)
        words = refuse(signorom, "run", deck.name, folder=tmp_path)
        assert words.startswith("results/patch/snapshots.h5: error: ")
    with h5py.File(results / "snapshots.h5", "w") as file:
        file["something"] = np.arange(3)
    assert refuse(signorom, "run", deck.name, folder=tmp_path).startswith(
        "results/patch/snapshots.h5: error: "
    )


@pytest.mark.parametrize(("command", "missing"), [("train", "snapshots"), ("validate", "model")])
def test_stage_before_is_missing(signorom, tmp_path, command, missing):
    deck = write_deck("patch", tmp_path)
    words = refuse(signorom, command, deck.name, folder=tmp_path)
    assert re.match(
        rf"results/patch/{missing}.h5: error: there (is|are) no {missing} yet\nhint: run first: signorom",
        words,
    )


def test_model_of_another_deck_is_not_validated(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    signorom("run", deck.name, folder=tmp_path)
    deck.write_text(deck.read_text().replace("young_modulus: 2.0e6", "young_modulus: 2.1e6"))
    words = refuse(signorom, "validate", deck.name, folder=tmp_path)
    assert re.match(r"results/patch/model.h5: error: .* another deck, mesh or field file", words)


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_two_runs_in_one_folder(signorom, many_points, uninterrupted, n_ranks):
    """The second leaves at once and the first does not notice; it sleeps meanwhile, so that it cannot end before."""
    deck, results = many_points
    first = signorom.start("sample", deck.name, folder=deck.parent)
    try:
        wait_until(lambda: n_records(results) > 10, first)
        first.send_signal(signal.SIGSTOP)
        second = signorom.run("run", deck.name, folder=deck.parent, n_ranks=n_ranks, time_limit=30)
        first.send_signal(signal.SIGCONT)
    except BaseException:
        kill(first)
        raise
    assert second.returncode == 2
    assert re.match(r"results/patch.*: error: another run", second.stderr), second.stderr
    assert finish(first).returncode == 0
    snapshots = read_snapshots(results / "snapshots.h5")
    np.testing.assert_array_equal(snapshots["displacement"], uninterrupted["displacement"])


def test_check_does_not_need_the_folder(signorom, many_points):
    deck, results = many_points
    first = signorom.start("sample", deck.name, folder=deck.parent)
    wait_until(lambda: n_records(results) > 10, first)
    done = signorom.run("check", deck.name, folder=deck.parent)
    kill(first)
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("directory", "n_ranks"), on_ranks([("/proc/results",), ("taken",), ("taken/below",)])
)
def test_folder_that_cannot_be_made(signorom, tmp_path, directory, n_ranks):
    (tmp_path / "taken").write_text("a file\n")
    deck = write_deck("patch", tmp_path, **{"output:\n": f"output:\n  directory: {directory}\n"})
    words = refuse(signorom, "run", deck.name, folder=tmp_path, n_ranks=n_ranks)
    assert re.match(rf"\S*{directory}\S*: error: ", words), words


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission(signorom, tmp_path):
    deck = write_deck("patch", tmp_path)
    (tmp_path / "results" / "patch").mkdir(parents=True)
    (tmp_path / "results" / "patch").chmod(0o500)
    words = refuse(signorom, "run", deck.name, folder=tmp_path)
    assert re.match(r"results/patch\S*: error: .*[Pp]ermission", words)


@pytest.mark.parametrize("number", [None, signal.SIGTERM])
def test_results_removed_meanwhile(signorom, many_points, number):
    """The run does not go on in vain, and does not say that finished points are kept."""
    deck, results = many_points
    process = signorom.start("sample", deck.name, folder=deck.parent)
    wait_until(lambda: n_records(results) > 0, process)
    shutil.rmtree(results)
    if number is not None:
        process.send_signal(number)
    done = finish(process, 60)
    assert done.returncode == 2
    assert "kept" not in done.stdout
    assert done.stderr.startswith(
        "results/patch/snapshots.part-1: error: the file of the finished points was removed or moved"
    )


@pytest.mark.parametrize("command", ["run", "solve"])
def test_report_that_cannot_be_written_ends_all_ranks(signorom, tmp_path, command):
    """One rank writes report.yaml; the others must hear of its error and not go on."""
    deck = write_deck("small_disks", tmp_path)
    signorom("run", deck.name, folder=tmp_path)
    report = tmp_path / "results" / "small_disks" / "report.yaml"
    report.unlink()
    report.mkdir()
    done = signorom.run(command, deck.name, folder=tmp_path, n_ranks=3)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("report.yaml: error: cannot write the file") == 1
    assert "PETSC ERROR" not in done.stderr
    assert "MPI_ABORT" not in done.stderr


@pytest.mark.skipif(mpi_needs_large_files(), reason="this MPI cannot start with small files")
def test_full_disk(signorom, many_points):
    """A shard that may not grow any more stands for it: a sentence, no crash; the finished points stay."""
    deck, results = many_points
    limit = HEADER + 100 * RECORD
    process = signorom.start("sample", deck.name, folder=deck.parent)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (limit, limit))
    done = finish(process, 60)
    assert done.returncode == 2, done.stderr
    assert re.match(r"results/patch/snapshots.part-1: error: cannot write the snapshot: ", done.stderr)
    finished = n_records(results)
    assert finished == 100
    write_points(deck, 200)
    assert f"({finished} were there)" in signorom("sample", deck.name, folder=deck.parent)


@pytest.mark.skipif(mpi_needs_large_files(), reason="this MPI cannot start with small files")
def test_full_disk_at_each_file(signorom, tmp_path):
    """A file that does not fit is refused with a sentence and leaves nothing behind; the next run ends the work."""
    # so many fields that their file is the largest: a limit hits the largest file first
    points = ", ".join(f"{{squeeze: 0.{i}}}" for i in range(20, 45, 2))
    deck = write_deck(
        "small_disks", tmp_path, **{"points: [{squeeze: 0.2}, {squeeze: 0.4}]": f"points: [{points}]"}
    )
    results = tmp_path / "results" / "small_disks"
    signorom("run", deck.name, folder=tmp_path)
    names = ("snapshots.h5", "model.h5", "fields.h5")
    sizes = {name: (results / name).stat().st_size for name in names}
    assert sorted(sizes, key=sizes.get) == list(names), "the limit would hit another file"
    for i, name in enumerate(names):
        shutil.rmtree(results)
        process = signorom.start("run", deck.name, folder=tmp_path)
        limit = sizes[name] - 500
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (limit, limit))
        done = finish(process, 60)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith(f"results/small_disks/{name}: error: cannot write the file")
        # validate writes model.h5 once more, larger: then the trained one stays
        left = {path.name for path in results.iterdir()} - {
            ".lock",
            "report.yaml",
            "enrichment.csv",
            "validation.csv",
            "model.h5",
        }
        assert left == ({"snapshots.h5"} if i else {"snapshots.part-1"})
        signorom("run", deck.name, folder=tmp_path)


def test_points_of_a_killed_run_outlive_other_training_points(signorom, killed):
    """Solved points stay when the deck asks for others in between."""
    deck, results = killed(1)
    n_solved, n_points = n_records(results), last_point(results) + 100
    text = deck.read_text()
    deck.write_text(text.replace("file: points.csv", "grid: {push: 7}"))
    signorom("sample", deck.name, folder=deck.parent)
    deck.write_text(text)
    write_points(deck, n_points)
    output = signorom("sample", deck.name, folder=deck.parent)
    assert int(re.search(r"\((\d+) were there\)", output).group(1)) >= n_solved
