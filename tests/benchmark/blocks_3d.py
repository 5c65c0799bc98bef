#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Two boxes of H8 in contact at growing size: time, memory and iterations of active_set with multigrid.

    build/venv/bin/python tests/benchmark/blocks_3d.py                 # 54 and 195 thousand dofs, 2 ranks
    build/venv/bin/python tests/benchmark/blocks_3d.py 54 195 1000     # a million too: 14 GB
    build/venv/bin/python tests/benchmark/blocks_3d.py --linear cholesky 54
    build/venv/bin/python tests/benchmark/blocks_3d.py --mortar --high 3 195 1000    # flat, facets do not match

The boxes of boxes.py. Prints a table; times are wall clock but for CPU, which is user time of all ranks together;
memory is the sum of the ranks' largest. `share` is the time of pairing and integration over that of assembly, set-up
and solution.
"""

import tempfile
from pathlib import Path

import yaml
from boxes import AT_ONE_POINT, deck_text, write_boxes
from timing import build, command_line, launcher, load_text, measure, tell_target

# thousand dofs: cells along each side of the contact face, along the height of a box; cells always about twice as high
# as wide, because multigrid feels their shape
SIZES = {1: (8, 2), 13: (18, 5), 54: (31, 8), 195: (49, 12), 1000: (85, 22)}
# cells along a side of the upper box over those of the lower one, where they do not match
MORTAR_RATIO = 1.225
LARGEST_SHARE = 0.1


def run(
    program,
    folder,
    size,
    n_ranks=2,
    *,
    high=None,
    is_mortar=False,
    solver="active_set",
    linear="gamg",
    words=(),
):
    """Solve one point; the report and what it took."""
    side, own_high = SIZES[size]
    high = high or own_high
    upper = round(MORTAR_RATIO * side) if is_mortar else side
    write_boxes(folder / "boxes.msh", "H8", [side, side, high], upper_counts=[upper, upper, high])
    text = deck_text(
        "H8",
        solver=f"type: {solver}, linear: {linear}",
        rest=AT_ONE_POINT.replace("}]}", "}], fields: [displacement, contact]}"),
    )
    if is_mortar:
        text = text.replace("direction: [0, 0, 1], ", "")
    (folder / "boxes.yaml").write_text(text)
    done = measure([*launcher(n_ranks), program, "solve", "boxes.yaml", "--quiet", *words], folder)
    report = yaml.safe_load((folder / "results" / "boxes" / "report.yaml").read_text())
    return report, done


def main():
    """A line per size."""
    parser = command_line(__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=[54, 195], help=f"thousand dofs: {[*SIZES]}")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--solver", default="active_set")
    parser.add_argument("--linear", default="gamg")
    parser.add_argument("--high", type=int, help="cells along the height of a box")
    parser.add_argument("--mortar", action="store_true", help="facets that do not match")
    parser.add_argument("--options", default="", help="PETSc options")
    options = parser.parse_args()
    (program,) = build("signorom")
    print(f"{options.solver}, {options.linear}, {options.ranks} ranks; {load_text()}")
    print(
        "    dofs  pairs closed steps CG/step  total   mesh pairing share partition assembly  set-up "
        "  solve output   GB    CPU  force balance"
    )
    shares = []
    for size in options.sizes:
        with tempfile.TemporaryDirectory() as folder:
            report, done = run(
                program,
                Path(folder),
                size,
                options.ranks,
                high=options.high,
                is_mortar=options.mortar,
                solver=options.solver,
                linear=options.linear,
                words=options.options.split(),
            )
        times, point = report["times"], report["points"]["1"]
        shares.append(times["pairing"] / (times["assembly"] + times["setup"] + point["seconds"]))
        n_dofs, n_pairs = report["sizes"]["n_dofs"], report["sizes"]["n_multipliers"]
        per_step = point["linear_iterations"] / point["iterations"]
        print(
            f"{n_dofs:8d} {n_pairs:6d} {point['n_active']:6d} {point['iterations']:5d} {per_step:7.1f} "
            f"{done.wall:6.1f} {times['mesh']:6.2f} {times['pairing']:7.2f} {shares[-1]:5.1%} "
            f"{times['partition']:9.2f} {times['assembly']:8.2f} {times['setup']:7.1f} {point['seconds']:6.1f} "
            f"{times['output']:6.1f} {done.megabytes / 1e3:4.1f} {done.user:6.1f} "
            f"{point['residuals']['force_balance']:.1e}",
            flush=True,
        )
    tell_target(f"pairing takes at most {LARGEST_SHARE:.0%} of the rest", max(shares) <= LARGEST_SHARE)


if __name__ == "__main__":
    main()
