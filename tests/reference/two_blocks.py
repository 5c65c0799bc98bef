# SPDX-License-Identifier: BSD-3-Clause
"""POD, DEIM and the blocks of (10) on a mesh of two blocks, in dense NumPy: what tests/unit/reduction compares with.

Independent of the program. Run: python3 two_blocks.py > two_blocks.txt
"""

import numpy as np

N_X, N_Y, GAP = 4, 2, 0.1
YOUNG_MODULUS, POISSON_RATIO = 15.0, 0.35
N_NODES = 2 * (N_X + 1) * (N_Y + 1)
N_DOFS = 2 * N_NODES
N_MODES, N_TERMS, N_SNAPSHOTS = 3, 2, 6
SEEDS = [6, 13]  # 1-based; the first makes the corner of its block interior, whose partner then has to join


def two_blocks():
    """Coordinates and 0-based triangles: squares a b c d become a b c and a c d, the lower block first."""
    points, cells = [], []
    for block in range(2):
        for j in range(N_Y + 1):
            for i in range(N_X + 1):
                a = len(points)
                points.append([i, j + block * (N_Y + GAP)])
                if i < N_X and j < N_Y:
                    up = a + N_X + 1
                    cells += [[a, a + 1, up + 1], [a, up + 1, up]]
    return np.array(points, dtype=float), np.array(cells)


def stiffness(points, cells):
    """Plane strain, from gradients of the barycentric coordinates (rows of the inverse of [1 x y])."""
    factor = YOUNG_MODULUS / ((1 + POISSON_RATIO) * (1 - 2 * POISSON_RATIO))
    hooke = factor * np.array(
        [
            [1 - POISSON_RATIO, POISSON_RATIO, 0],
            [POISSON_RATIO, 1 - POISSON_RATIO, 0],
            [0, 0, 0.5 - POISSON_RATIO],
        ]
    )
    result = np.zeros((N_DOFS, N_DOFS))
    for cell in cells:
        corners = np.column_stack([np.ones(3), points[cell]])
        gradients = np.linalg.inv(corners)[1:]
        strain = np.zeros((3, 6))
        strain[0, 0::2], strain[1, 1::2] = gradients
        strain[2, 0::2], strain[2, 1::2] = gradients[::-1]
        dofs = np.column_stack([2 * cell, 2 * cell + 1]).ravel()
        result[np.ix_(dofs, dofs)] += 0.5 * np.linalg.det(corners) * strain.T @ hooke @ strain
    return result


def contact_rows():
    """+1 on the y dof of the lower face's node, -1 on that of the upper face's."""
    rows = np.zeros((N_X + 1, N_DOFS))
    for k in range(N_X + 1):
        first = N_Y * (N_X + 1) + k
        rows[k, 2 * first + 1] = 1
        rows[k, 2 * (first + N_X + 1) + 1] = -1
    return rows


def wavy(n_rows, n_columns, shift):
    """Any matrix without structure that both languages compute alike."""
    i, j = np.meshgrid(np.arange(1, n_rows + 1), np.arange(1, n_columns + 1), indexing="ij")
    return np.sin(0.7 * i * j + shift) / j**2


def domain(cells, seeds, rows):
    """Sets by their definitions (4)-(9), with the partners of interior nodes added until none is missing."""
    other = {}
    for row in rows:
        first, second = (int(dof) // 2 for dof in np.flatnonzero(row))
        other[first], other[second] = second, first
    support = set(seeds) | {other[node] for node in seeds if node in other}
    while True:
        inside = np.array([bool(set(cell) & support) for cell in cells])
        interior = set(cells[inside].ravel()) - set(cells[~inside].ravel())
        missing = {other[node] for node in interior if node in other} - interior
        if not missing:
            return sorted(support - set(seeds)), np.flatnonzero(inside), sorted(interior)
        support |= missing


def deim(basis):
    """Chaturantabut and Sorensen 2010, algorithm 1."""
    rows = [int(np.argmax(abs(basis[:, 0])))]
    for k in range(1, basis.shape[1]):
        coefficients = np.linalg.solve(basis[rows, :k], basis[rows, k])
        rows.append(int(np.argmax(abs(basis[:, k] - basis[:, :k] @ coefficients))))
    return np.array(rows)


def show(name, values):
    """One block: name and shape, then a line per row."""
    values = np.atleast_2d(values)
    print(name, *values.shape)
    for row in values:
        print(*(repr(float(value)) for value in row))


def main():
    """Everything that the unit tests of the reduction read."""
    points, cells = two_blocks()
    full, rows = stiffness(points, cells), contact_rows()
    basis, lifting = wavy(N_DOFS, N_MODES, 0.0), wavy(N_DOFS, N_TERMS, 1.0)
    facing, in_domain, interior = domain(cells, [node - 1 for node in SEEDS], rows)
    inner = np.array([[2 * node, 2 * node + 1] for node in interior]).ravel()
    coupled = np.setdiff1d(np.flatnonzero((full[inner] != 0).any(axis=0)), inner)
    contact = inner[(rows[:, inner] != 0).any(axis=0)]
    active = np.flatnonzero((rows[:, contact] != 0).any(axis=1))
    wide = np.union1d(inner, coupled)
    show("facing_nodes", np.array(facing) + 1)
    show("cells", in_domain + 1)
    show("interior_dofs", inner + 1)
    show("contact_dofs", contact + 1)
    show("contact_rows", active + 1)
    projected = basis[inner].T @ full[np.ix_(inner, wide)]
    show("reduced_stiffness", projected @ basis[wide])
    show("load", -projected @ lifting[wide])
    show("contact_matrix", rows[np.ix_(active, contact)] @ basis[contact])
    gap = np.zeros((len(active), N_TERMS))
    gap[:, 0] = GAP
    show("gap", gap - rows[active] @ lifting)
    show("full_stiffness", basis.T @ full @ basis)
    snapshots = wavy(N_DOFS, N_SNAPSHOTS, 2.0)
    vectors, values, _ = np.linalg.svd(snapshots, full_matrices=False)
    show("singular_values", values)
    show("deim_rows", deim(vectors[:, :4]) + 1)


if __name__ == "__main__":
    main()
