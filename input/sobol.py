# SPDX-License-Identifier: BSD-3-Clause
# %% [markdown]
# # Which parameter matters?
#
# Sobol indices of the fuel rod in `fuel_rod.yaml`: which share of the variance of the contact force comes from each of
# its eight parameters, alone (first order) and together with others (total)?
#
# SALib chooses the points and evaluates the answers; the reduced model answers all of them in one call.
#
#     signorom run input/fuel_rod.yaml
#     pip install 'tools/signorom_post[examples]'
#     python input/sobol.py

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as design

from signorom_post import Model

RESULTS = Path("results/sobol")
N_BASE = 1024  # a power of 2; N_BASE * (n_parameters + 2) answers
SEED = 14

model = Model("results/fuel_rod/model.h5")
RESULTS.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## Points and answers
#
# Each parameter is taken as equally likely in its trained range, so that no answer is an extrapolation. Where a study
# has other distributions, SALib knows them (`dists`), but the points must stay in the box.

# %%
problem = {
    "num_vars": len(model.parameters),
    "names": [parameter.name for parameter in model.parameters],
    "bounds": [[parameter.minimum, parameter.maximum] for parameter in model.parameters],
}
points = design.sample(problem, N_BASE, calc_second_order=False, seed=SEED)
answers = model.query_many(points)
force = answers.contact_force
assert answers.has_answer.all(), "a point without an answer would count as a number"
assert answers.is_inside_box.all()
print(f"{len(points)} answers; contact force {force.min():.4g} to {force.max():.4g} {model.force_unit}")
print(f"no contact at {np.mean(force == 0):.0%} of the points")

# %% [markdown]
# ## Indices
#
# The first-order index is the share of the variance that a parameter explains alone, the total index that of all in
# which it has a part. Both have intervals of 95 % by resampling.

# %%
found = analysis.analyze(problem, force, calc_second_order=False, seed=SEED)
print(f"{'':12}{'first order':>20}{'total':>20}")
for k, name in enumerate(problem["names"]):
    first = f"{found['S1'][k]:.3f} +- {found['S1_conf'][k]:.3f}"
    total = f"{found['ST'][k]:.3f} +- {found['ST_conf'][k]:.3f}"
    print(f"{name:12}{first:>20}{total:>20}")

# %% [markdown]
# ## Picture

# %%
order = np.argsort(found["ST"])
heights = np.arange(len(order))
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.barh(heights + 0.2, found["S1"][order], 0.4, xerr=found["S1_conf"][order], label="first order")
axes.barh(heights - 0.2, found["ST"][order], 0.4, xerr=found["ST_conf"][order], label="total")
axes.set_yticks(heights, [problem["names"][k] for k in order])
axes.set_xlabel("share of the variance of the contact force")
axes.legend()
figure.savefig(RESULTS / "indices.png", dpi=150)
