# SPDX-License-Identifier: BSD-3-Clause
# %% [markdown]
# # The smallest gap that is safe
#
# A small gap between pellet and cladding keeps the fuel rod in `fuel_rod.yaml` cool. Too small a gap lets the pellet
# press on the cladding. What is the smallest gap for which the contact force at full power stays below a limit, for
# each combination of elastic constants that the suppliers allow?
#
# scipy solves it with the derivatives of the reduced model. The full-order model then checks the answer.
#
#     signorom run input/fuel_rod.yaml
#     pip install 'tools/signorom_post[examples]'
#     python input/optimisation.py

# %%
import itertools
import os
import subprocess
from pathlib import Path

import numpy as np
import yaml
from scipy.optimize import minimize

from signorom_post import Model

PROGRAM = os.environ.get("SIGNOROM_EXECUTABLE", "signorom")
FULL_POWER = {"q": 40.0, "P": 15.0, "h": 6.0}  # W/mm, MPa, mm
LIMIT = 15000.0  # N, largest contact force

model = Model("results/fuel_rod/model.h5")
ranges = {parameter.name: (parameter.minimum, parameter.maximum) for parameter in model.parameters}
CONSTANTS = ["E_fuel", "nu_fuel", "E_cladding", "nu_cladding"]
corners = [
    dict(zip(CONSTANTS, ends, strict=True)) for ends in itertools.product(*(ranges[n] for n in CONSTANTS))
]

# %% [markdown]
# ## Contact forces of all corners, and their derivatives


# %%
def answers_at(gap):
    """One answer per corner, without displacements; its derivatives are computed when they are asked for."""
    return [model.query(nodes=[], gap=float(gap), **FULL_POWER, **corner) for corner in corners]


def room(gap):
    """What each corner leaves of the limit, as a share of it; shape (16)."""
    return 1 - np.array([answer.contact_force for answer in answers_at(gap)]) / LIMIT


def slope_of_room(gap):
    """Derivative with respect to the gap, shape (16)."""
    column = list(ranges).index("gap")
    slopes = [answer.gradient.multipliers[column].sum() for answer in answers_at(gap)]
    return -np.array(slopes) / LIMIT


# %% [markdown]
# ## The optimum
#
# The gap counts as a share of its range, so that scipy sees numbers of size 1.

# %%
low, high = ranges["gap"]
found = minimize(
    lambda share: share[0],
    x0=[0.5],
    jac=lambda _: np.ones(1),
    bounds=[(0, 1)],
    constraints={
        "type": "ineq",
        "fun": lambda share: room(low + share[0] * (high - low)),
        "jac": lambda share: slope_of_room(low + share[0] * (high - low))[:, None] * (high - low),
    },
    method="SLSQP",
    options={"ftol": 1e-8},
)
if not found.success:
    raise SystemExit(f"no gap in {low} to {high} meets the limit: {found.message}")
gap = low + found.x[0] * (high - low)
worst = corners[int(np.argmin(room(gap)))]
answer = model.query(nodes=[], gap=gap, **FULL_POWER, **worst)
print(f"smallest gap: {gap:.6f} {model.length_unit} after {found.nit} steps")
print(f"worst corner: {', '.join(f'{name}={value:g}' for name, value in worst.items())}")
print(f"contact force by the model: {answer.contact_force:.6g} {model.force_unit}, limit {LIMIT:g}")

# %% [markdown]
# ## The full order has the last word

# %%
point = ",".join(f"{name}={value!r}" for name, value in (FULL_POWER | worst | {"gap": float(gap)}).items())
command = [PROGRAM, "solve", "input/fuel_rod.yaml", "--at", point]
subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
report = yaml.safe_load(Path("results/fuel_rod/report.yaml").read_text())
full_order = -report["points"]["1"]["contacts"]["1"]["force"][0]
print(f"contact force by the full order: {full_order:.6g} {model.force_unit}")
print(f"limit exceeded by {max(0, full_order / LIMIT - 1):.1e} of it")
