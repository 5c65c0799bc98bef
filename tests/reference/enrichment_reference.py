# SPDX-License-Identifier: BSD-3-Clause
"""Algorithm 1 by plain singular value decompositions, one per candidate and step.

Independent of the program, which updates singular values instead. Source: Le Berre et al. 2022, section 3.3, with the
gaps of the paper closed: a candidate is one hat function per pair; the best one of a sweep joins even where it raises
kappa; while there are fewer columns than rows the smallest value that there is counts; it ends at kappa_max with full
rank, or when every pair has a hat.
"""

import numpy as np

from reduction_reference import RANK_TOLERANCE, TIE
from two_blocks import show, wavy


def singular_ratio(matrix):
    """Largest singular value over the smallest of the min(rows, columns) values; infinite where that is zero."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 0 else np.inf


def condition_and_rank(matrix):
    """Kappa of (11), infinite below full row rank, and the rank."""
    values = np.linalg.svd(matrix, compute_uv=False)
    rank = int((values >= RANK_TOLERANCE * values[0]).sum())
    return (float(values[0] / values[-1]) if rank == len(matrix) else np.inf), rank


def enrich(contact, hats, max_condition_number, max_hats=None):
    """Rows whose hat joins, in the order of the choice, and the history [(columns, kappa, rank, ratio)] with the start.

    contact: M = B V, rows by modes; hats: the entry of each row's hat in its own row of M (one per pair).
    """
    matrix, chosen = contact, []
    left = list(range(len(contact)))
    history = [(matrix.shape[1], *condition_and_rank(matrix), singular_ratio(matrix))]
    while left and (max_hats is None or len(chosen) < max_hats):
        kappa, rank = history[-1][1:3]
        if kappa <= max_condition_number and rank == len(contact):
            break
        trials = [np.column_stack([matrix, hats[row] * np.eye(len(contact))[row]]) for row in left]
        ratios = np.array([singular_ratio(trial) for trial in trials])
        best = int(np.flatnonzero(ratios <= ratios.min() * (1 + TIE))[0])
        matrix = trials[best]
        chosen.append(left.pop(best))
        history.append((matrix.shape[1], *condition_and_rank(matrix), float(ratios[best])))
    return chosen, history


def main():
    """What tests/unit/reduction/test_enrichment.pf reads: python3 enrichment_reference.py > enrichment_reference.txt."""
    for name, n_modes, maximum in (("narrow", 5, 10.0), ("full", 5, 1.0), ("wide", 14, 3.0)):
        contact = wavy(12, n_modes, 0.3)
        chosen, history = enrich(contact, -np.ones(12), maximum)
        columns, kappas, ranks, ratios = zip(*history, strict=True)
        show(f"{name}_rows", np.array(chosen) + 1)
        show(f"{name}_columns", columns)
        show(f"{name}_ranks", ranks)
        # no infinity in a file that Fortran reads as numbers
        show(f"{name}_kappas", [-1.0 if np.isinf(kappa) else kappa for kappa in kappas])
        show(f"{name}_ratios", ratios)


if __name__ == "__main__":
    main()
