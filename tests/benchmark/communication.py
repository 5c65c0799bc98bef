#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What ranks tell each other while they solve one point together, and what a model makes of it for more ranks.

    build/venv/bin/python tests/benchmark/communication.py                        # 54 thousand dofs on 1, 2 and 4 ranks
    build/venv/bin/python tests/benchmark/communication.py 54 195 1000 --predict 16 64 256

The boxes of boxes.py by `active_set` with multigrid. PETSc counts messages, bytes and reductions of each event
(-log_view). They do not depend on the load of the machine. An iteration is an application of the preconditioner inside
of a linear solution. Messages and bytes are those that a rank sends, the mean of all ranks. Reductions and broadcasts
that the program calls by itself, between linear solutions, are counted by `count_reductions.c`: whole arrays of dofs,
8 bytes per dof each, which do not become smaller with more ranks.

The model: a body is cut into as many equal blocks as there are ranks. Bytes go with the area of the cuts, messages with
the number of neighbors (blocks that share a face, an edge or a corner). Both are scaled from the measured 2 ranks, so
that the line of 4 ranks shows how good the model is. T(1) is CPU time, and an iteration takes

    T(P) = T(1) / P + messages * latency + bytes / bandwidth + reductions * log2(P) * latency

The whole command: what each rank repeats for itself (mesh, pairing, partition), the iterations, the rest of assembly,
set-up and steps over P, and the program's own reductions, each of which sends and gets its bytes once:

    repeated + iterations * T(P) + rest / P + number * 2 log2(P) * latency + 2 bytes / bandwidth
"""

import csv
import itertools
import math
import os
import subprocess
import tempfile
from pathlib import Path

import blocks_3d
import numpy as np
from timing import build, command_line, load_text, waiting

# both boxes together: 1 x 1 x 1
BOX = (1.0, 1.0, 1.0)
EVENTS = {"iteration": "KSPSolve", "set-up": "PCSetUp"}
ITERATION = "PCApply"


def blocks_of(n_ranks):
    """Numbers of blocks along the axes of a box with the smallest area of all cuts, which comes with them."""
    shapes = [
        shape
        for shape in itertools.product(range(1, n_ranks + 1), repeat=len(BOX))
        if math.prod(shape) == n_ranks
    ]
    return min((cut_area(shape), shape) for shape in shapes)


def cut_area(shape):
    """Area of all cuts."""
    return sum((n - 1) * math.prod(BOX) / BOX[axis] for axis, n in enumerate(shape))


def mean_neighbors(shape):
    """Mean number of the blocks that touch a block: along an axis n blocks have 3 n - 2 pairs, each with itself too."""
    return math.prod(3 * n - 2 for n in shape) / math.prod(shape) - 1


def modelled(measured_on_2, n_ranks):
    """Messages and bytes of a rank, from those of two ranks."""
    area, shape = blocks_of(n_ranks)
    messages = measured_on_2["messages"] * mean_neighbors(shape)
    return messages, measured_on_2["bytes"] * area / (n_ranks / 2)


def read_log(path, n_ranks):
    """Count, seconds, messages, bytes and reductions of the events of a rank, means of all ranks: event -> values."""
    rows = {}
    with path.open() as file:
        for row in csv.reader(file):
            if row and row[0] == "Main Stage":
                rows.setdefault(row[1].strip(), []).append([float(value) for value in row[3:8]])
    names = ("count", "seconds", "messages", "bytes", "reductions")
    found = {}
    for name, values in rows.items():
        assert len(values) == n_ranks, (name, len(values))
        found[name] = dict(zip(names, np.mean(values, axis=0), strict=True))
        # PETSc counts a message where it is sent and where it comes
        found[name]["messages"] /= 2
        found[name]["bytes"] /= 2
    return found


def build_counter(folder):
    """Path of count_reductions.c as a library."""
    library = folder / "count_reductions.so"
    source = Path(__file__).with_name("count_reductions.c")
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", source, "-o", library, "-ldl"], check=True)
    return library


def own_reductions(folder):
    """Number and bytes of the program's own reductions and broadcasts, means of all ranks."""
    files = [path.read_text().split() for path in folder.glob("counts.*")]
    counts = np.array(files, dtype=float).reshape(-1, 2, 2)
    return counts.sum(axis=1).mean(axis=0)


def run(program, size, n_ranks):
    """The report, what PETSc counted by event, the program's own reductions, and CPU time over wall time."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        os.environ["LD_PRELOAD"] = str(build_counter(folder))
        os.environ["COUNT_REDUCTIONS"] = str(folder / "counts")
        os.environ["PETSC_OPTIONS"] = f"-log_view :{folder / 'log.csv'}:ascii_csv"
        # waiting ranks give their core away, where there are more ranks than cores
        os.environ.update(waiting(n_ranks))
        report, done = blocks_3d.run(program, folder, size, n_ranks)
        del os.environ["LD_PRELOAD"]
        return report, read_log(folder / "log.csv", n_ranks), own_reductions(folder), done.cpu / done.wall


def print_measured(report, log, own, on_2, n_ranks):
    """A line per number of ranks; returns what an iteration takes."""
    n_iterations = log[ITERATION]["count"]
    of_solve, of_setup = log[EVENTS["iteration"]], log[EVENTS["set-up"]]
    each = {name: of_solve[name] / n_iterations for name in ("seconds", "messages", "bytes", "reductions")}
    model = "" if on_2 is None else "{:8.1f} {:7.1f}".format(*scaled(*modelled(on_2, n_ranks)))
    print(
        f"{report['sizes']['n_dofs']:8d} {n_ranks:5d} {n_iterations:6.0f} | {each['messages']:8.1f} "
        f"{each['bytes'] / 1e3:7.1f} {each['reductions']:10.2f} | {model:16s} | {of_setup['messages']:8.0f} "
        f"{of_setup['bytes'] / 1e6:6.2f} {of_setup['reductions']:10.0f} | {own[0]:6.0f} {own[1] / 1e6:7.1f}",
        flush=True,
    )
    return each | {"iterations": n_iterations, "own": own}


def scaled(messages, n_bytes):
    """Messages and kB."""
    return messages, n_bytes / 1e3


def print_predicted(options, report, cpu_share, on_1, on_2):
    """A line per number of ranks that the model is asked for; `cpu_share`: CPU time over wall time on one rank.

    For more dofs, work and the program's own bytes grow with their number, bytes of an iteration with its power 2/3.
    """
    times, point = report["times"], report["points"]["1"]
    n_dofs = options.dofs or report["sizes"]["n_dofs"]
    growth = n_dofs / report["sizes"]["n_dofs"]
    cpu_share *= growth
    repeated = cpu_share * (times["mesh"] + times["pairing"] + times["partition"])
    shared = cpu_share * (times["assembly"] + times["setup"] + point["seconds"])
    of_iteration = cpu_share * on_1["seconds"]
    rest = max(0.0, shared - on_1["iterations"] * of_iteration)
    print(
        f"    {n_dofs:.0f} dofs, CPU time on one rank: {1e3 * of_iteration:.1f} ms per iteration; "
        f"repeated {repeated:.2f} s, iterations {on_1['iterations'] * of_iteration:.2f} s, the rest {rest:.2f} s"
    )
    print(
        "       ranks    blocks messages      kB | ms: work messages  bytes reductions | gain of an iteration"
        " | s: repeated iter.   rest    own | gain"
    )
    for n_ranks in options.predict:
        _, shape = blocks_of(n_ranks)
        messages, n_bytes = modelled(on_2, n_ranks)
        n_bytes *= growth ** (2 / 3)
        depth = math.log2(n_ranks)
        parts = [
            of_iteration / n_ranks,
            messages * options.latency,
            n_bytes / options.bandwidth,
            on_2["reductions"] * depth * options.latency,
        ]
        n_own, own_bytes = on_2["own"] * np.array([1, growth])
        whole = [
            repeated,
            on_1["iterations"] * sum(parts),
            rest / n_ranks,
            n_own * 2 * depth * options.latency + 2 * own_bytes / options.bandwidth,
        ]
        work, of_messages, of_bytes, of_reductions = (1e3 * part for part in parts)
        print(
            f"    {n_ranks:8d} {'x'.join(map(str, shape)):>9s} {messages:8.1f} {n_bytes / 1e3:7.1f} | {work:8.3f} "
            f"{of_messages:8.3f} {of_bytes:6.3f} {of_reductions:10.3f} | {of_iteration / sum(parts):20.1f} | "
            f"{whole[0]:11.2f} {whole[1]:5.2f} {whole[2]:6.2f} {whole[3]:6.2f} | {(repeated + shared) / sum(whole):4.1f}"
        )


def main():
    """Tables for each size."""
    parser = command_line(__doc__)
    parser.add_argument(
        "sizes", nargs="*", type=int, default=[54], help=f"thousand dofs: {[*blocks_3d.SIZES]}"
    )
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2, 4], help="1 first, then 2")
    parser.add_argument(
        "--predict", nargs="+", type=int, default=[16, 64], help="ranks that the model is asked for"
    )
    parser.add_argument("--dofs", type=float, help="of the prediction; default: those of the run")
    parser.add_argument("--latency", type=float, default=2e-6, help="of a message [s]")
    parser.add_argument("--bandwidth", type=float, default=1e9, help="of a rank [bytes/s]")
    options = parser.parse_args()
    (program,) = build("signorom")
    print(load_text())
    print(
        "                        per iteration and rank           | model            | set-up, per rank        "
        "     | own"
    )
    print(
        "    dofs ranks  iter. | messages      kB reductions | messages      kB | messages     MB reductions "
        "| number      MB"
    )
    for size in options.sizes:
        measured, first = {}, None
        for n_ranks in options.ranks:
            report, log, own, cpu_share = run(program, size, n_ranks)
            first = first or (report, cpu_share)
            on_2 = measured.get(2) if n_ranks > 2 else None
            measured[n_ranks] = print_measured(report, log, own, on_2, n_ranks)
        print_predicted(options, *first, measured[1], measured[2])


if __name__ == "__main__":
    main()
