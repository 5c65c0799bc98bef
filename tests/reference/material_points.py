# SPDX-License-Identifier: BSD-3-Clause
"""Strain paths of one material point by backward Euler, without radial return: all tensors at once by a root finder.

Unknown in a step are the stress, the plastic strain tensor and the equivalent plastic strain. Equations are Hooke's
law, the flow rule along the deviator of the stress less the back stress at the end of the step, and the yield condition
(or no plastic flow).
"""

from pathlib import Path

import numpy as np
from scipy.optimize import root

E, NU = 200e3, 0.3  # MPa
STRESS, STRAIN = 100.0, 1e-3  # sizes of the unknowns
N_STEPS = 8
SHEARS = np.array([1, 1, 1, 2, 2, 2])  # angle over tensor component, and weight in the product of two tensors
CURVE = ([0.0, 1e-3, 4e-3, 1e-2], [250.0, 300.0, 330.0, 345.0])
CASES = {
    # properties in the order of src/materials; strains of the hardening curve; A, n; H_k
    "perfect": ([E, NU, 0, 0, 250], [0], 0, 1, 0),
    "linear": ([E, NU, 0, 8e3, 250], [0], 0, 1, 0),
    "prager": ([E, NU, 12e3, 0, 250], [0], 0, 1, 12e3),
    "curve": ([E, NU, 0, 0, *CURVE[1]], CURVE[0], 0, 1, 0),
    "norton": ([E, NU, 3e-15, 5], [0], 3e-15, 5, 0),
    "newtonian": ([E, NU, 2e-6, 1], [0], 2e-6, 1, 0),
    "both": ([E, NU, 4e-16, 5, 8e3, 250], [0], 4e-16, 5, 0),
    "curve_and_creep": ([E, NU, 2e-13, 4, 0, *CURVE[1]], CURVE[0], 2e-13, 4, 0),
}


def path():
    """Strains xx, yy, zz, xy, yz, xz (tensor components) and lengths of the steps: directions change, some return."""
    time = np.arange(1, N_STEPS + 1) / N_STEPS
    waves = [np.sin((2 + i) * time + i) - np.sin(i) for i in range(6)]
    return 2.5e-3 * np.array(waves).T, 0.5 + time


def deviator(tensor):
    return tensor - tensor[:3].mean() * np.array([1, 1, 1, 0, 0, 0])


def equivalent(tensor):
    return np.sqrt(1.5 * np.sum(SHEARS * deviator(tensor) ** 2))


def hooke(strain):
    shear, lame = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    return 2 * shear * strain + lame * strain[:3].sum() * np.array([1, 1, 1, 0, 0, 0])


def yield_stress(case, p):
    """Behind the last point of a curve it stays; one point has the slope of the case."""
    properties, strains, coefficient, _, _ = CASES[case]
    n = len(strains)
    slope = properties[4 if coefficient > 0 else 3] if n == 1 else 0
    return np.interp(p, strains, properties[-n:]) + slope * max(0.0, p - strains[-1])


def solve(case, strain, dt, old, is_plastic):
    """Stress, plastic strain and p at the end of a step; the creep strain is what Hooke's law leaves."""
    _, _, coefficient, exponent, kinematic = CASES[case]
    _, plastic0, creep0, p0, _ = old

    def residual(unknown):
        stress, plastic, p = unknown[:6] * STRESS, unknown[6:12] * STRAIN, unknown[12] * STRAIN
        xi = deviator(stress) - 2 / 3 * kinematic * plastic
        flow = 1.5 * xi / max(equivalent(xi), 1e-30)
        creep = creep0 + dt * coefficient * equivalent(stress) ** exponent * flow
        condition = (equivalent(xi) - yield_stress(case, p)) / STRESS if is_plastic else (p - p0) / STRAIN
        return np.concatenate(
            [
                (stress - hooke(strain - plastic - creep)) / STRESS,
                (plastic - plastic0 - (p - p0) * flow) / STRAIN,
                [condition],
            ]
        )

    elastic = hooke(strain - plastic0 - creep0)
    best = (np.inf, None)
    for share in (1.0, 0.9, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05):  # starts between the trial and its mean stress
        start = elastic - (1 - share) * deviator(elastic)
        guess = np.concatenate(
            [start / STRESS, plastic0 / STRAIN, [p0 / STRAIN + (0.1 if is_plastic else 0)]]
        )
        found = root(residual, guess, method="hybr", tol=1e-15)
        for _ in range(3):
            found = root(residual, found.x, method="hybr", tol=1e-15)
        error = np.abs(residual(found.x)).max()
        # equations alone also have roots with less plastic strain than before
        if (found.x[12] * STRAIN > p0 or not is_plastic) and error < best[0]:
            best = (error, found.x)
    assert best[0] < 1e-11, (case, best)
    stress, plastic, p = best[1][:6] * STRESS, best[1][6:12] * STRAIN, best[1][12] * STRAIN
    creep = creep0 + dt * coefficient * equivalent(stress) ** exponent * 1.5 * deviator(stress) / equivalent(
        stress
    )
    return stress, plastic, creep, p


def walk(case):
    """One row per step: strain with angles, dt, stress, p and the equivalent creep strain."""
    strains, steps = path()
    state = (np.zeros(6), np.zeros(6), np.zeros(6), 0.0, 0.0)
    rows = []
    for strain, dt in zip(strains, steps, strict=True):
        _, _, coefficient, exponent, kinematic = CASES[case]
        found = solve(case, strain, dt, state, False)
        has_yield = case not in ("norton", "newtonian")
        xi = deviator(found[0]) - 2 / 3 * kinematic * found[1]
        if has_yield and equivalent(xi) > yield_stress(case, state[3]):
            found = solve(case, strain, dt, state, True)
        creep_length = state[4] + dt * coefficient * equivalent(found[0]) ** exponent
        state = (*found, creep_length)
        rows.append([*(strain * SHEARS), dt, *state[0], state[3], state[4]])
    return rows


def matrix(name, rows):
    """A matrix as tests/unit/support/reference_file.f90 reads it."""
    lines = [" ".join(repr(float(number)) for number in row) for row in rows]
    return "\n".join([f"{name} {len(rows)} {len(rows[0])}", *lines, ""])


if __name__ == "__main__":
    text = ""
    for case, (properties, strains, *_) in CASES.items():
        text += (
            matrix(f"{case}_properties", [properties])
            + matrix(f"{case}_curve", [strains])
            + matrix(case, walk(case))
        )
    Path(__file__).with_suffix(".txt").write_text(text)
