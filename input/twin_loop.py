# SPDX-License-Identifier: BSD-3-Clause
# %% [markdown]
# # A digital twin of a fuel rod
#
# Ten gauges read the hoop strain of the cladding of the rod in `fuel_rod.yaml`. The load is known at each step. The gap
# is not: the pellet swells slowly. At each step the twin estimates the gap from the readings and tells the contact
# force that nobody can measure, with an interval. It says so where it cannot answer.
#
#     signorom run input/fuel_rod.yaml
#     pip install 'tools/signorom_post[examples]'
#     python input/twin_loop.py

# %%
import os
import re
import subprocess
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from signorom_post import Model

PROGRAM = os.environ.get("SIGNOROM_EXECUTABLE", "signorom")
RESULTS = Path("results/twin")
N_STEPS = 40
NOISE = 1.0e-5  # standard deviation of a gauge's reading [-]
SEED = 14
CONSTANTS = {"E_fuel": 190.0e3, "nu_fuel": 0.30, "E_cladding": 78.0e3, "nu_cladding": 0.34}

rng = np.random.default_rng(SEED)
model = Model("results/fuel_rod/model.h5")
ranges = {parameter.name: (parameter.minimum, parameter.maximum) for parameter in model.parameters}
RESULTS.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The loads, and the gap that the twin does not know
#
# The power follows the demand. For three steps it is above the range that the model was trained for.

# %%
steps = np.arange(N_STEPS)
power = 28 + 8 * np.sin(2 * np.pi * steps / N_STEPS * 2)
power[N_STEPS // 2 : N_STEPS // 2 + 3] = 42
loads = {"q": power, "P": 12 + 2 * np.cos(2 * np.pi * steps / N_STEPS), "h": np.full(N_STEPS, 5.8)}
true_gap = 0.022 - 0.010 * steps / N_STEPS  # mm

# %% [markdown]
# ## The readings
#
# There is no rod in this repository. The readings are full-order solutions with noise, on a wider range of the power.

# %%
names = list(ranges)
values = loads | {name: np.full(N_STEPS, value) for name, value in CONSTANTS.items()} | {"gap": true_gap}
table = np.column_stack([values[name] for name in names])
states = RESULTS / "states.csv"
np.savetxt(states, table, "%.17g", ",", header=",".join(names), comments="")
deck = Path("input/fuel_rod.yaml").read_text()
deck = re.sub(r"(?m)^(training|test): .*\n", "", deck) + f"training: {{file: {states.resolve()}}}\n"
deck = deck.replace("../meshes", str(Path("meshes").resolve())).replace(
    "max: 40.0, unit: W/mm", "max: 45.0, unit: W/mm"
)
(RESULTS / "measured_rod.yaml").write_text(deck)
command = [PROGRAM, "sample", RESULTS / "measured_rod.yaml"]
subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

tags, places = model.nodes
radius = places[:, 0].max()
outside = np.flatnonzero(np.isclose(places[:, 0], radius))
gauges = outside[abs(places[outside, 1] - np.linspace(0.8, 6.2, 10)[:, None]).argmin(axis=1)]
with h5py.File("results/measured_rod/snapshots.h5") as file:
    # the file keeps the points of earlier runs, too
    rows = [abs(file["parameters"][()] - point).sum(axis=1).argmin() for point in table]
    true_force = file["multipliers"][()][rows].sum(axis=1)
    displacement = file["displacement"][()][rows].reshape(N_STEPS, -1, 2)
readings = displacement[:, gauges, 0] / radius + NOISE * rng.standard_normal((N_STEPS, 10))

# %% [markdown]
# ## The loop: an extended Kalman filter with the derivatives of the model
#
# Between two steps the gap may change by about half a micrometer. What the readings say of it comes from the derivative
# of the strains; what the gap says of the contact force, from the derivative of the force.

# %%
DRIFT = 5.0e-4  # mm, standard deviation of the change of the gap in a step
gap, variance = sum(ranges["gap"]) / 2, 0.005**2
column = names.index("gap")
told = []
for i in steps:
    load = {name: loads[name][i] for name in loads}
    variance += DRIFT**2
    if any(not ranges[name][0] <= load[name] <= ranges[name][1] for name in load):
        told.append((np.nan, np.nan, np.nan, np.nan))
        print(f"step {i:2}: no estimate: the load lies outside of the trained range (q = {load['q']:g} W/mm)")
        continue
    # two iterations, because the strains are not linear where contact begins
    prior = gap
    for _ in range(2):
        answer = model.query(nodes=tags[gauges], gap=gap, **load, **CONSTANTS)
        gradient = answer.gradient
        slope = gradient.displacement[column, :, 0] / radius
        misfit = readings[i] - answer.displacement[:, 0] / radius - slope * (prior - gap)
        gain = variance * slope / (NOISE**2 + variance * slope @ slope)
        gap = float(np.clip(prior + gain @ misfit, *ranges["gap"]))
    variance *= 1 - gain @ slope
    answer = model.query(nodes=[], gap=gap, **load, **CONSTANTS)
    deviation = abs(answer.gradient.multipliers[column].sum()) * np.sqrt(variance)
    told.append((gap, np.sqrt(variance), answer.contact_force, deviation))
    if i % 5 == 0:
        print(
            f"step {i:2}: gap {1e3 * gap:5.2f} +- {1.96e3 * np.sqrt(variance):.2f} um, "
            f"contact force {answer.contact_force:6.0f} +- {1.96 * deviation:.0f} {model.force_unit}, "
            f"certificate {answer.relative_bound:.0e}"
        )

# %% [markdown]
# ## How good it was
#
# Here the truth is known: the full-order contact forces.

# %%
found_gap, gap_deviation, found_force, force_deviation = np.array(told).T
is_answered = np.isfinite(found_gap)
inside = (
    abs(found_force - true_force)[is_answered]
    <= 1.96 * force_deviation[is_answered] + 1e-6 * true_force.max()
)
print(
    f"answered {is_answered.sum()} of {N_STEPS} steps; the interval holds the true force at {inside.mean():.0%}"
)
worst = np.nanmax(abs(found_force - true_force)[5:])
print(f"largest error of the contact force after five steps: {worst:.0f} {model.force_unit}")

# %%
figure, panels = plt.subplots(2, 1, sharex=True, figsize=(7, 6), layout="constrained")
panels[0].plot(steps, 1e3 * true_gap, "k", label="truth")
panels[0].errorbar(steps, 1e3 * found_gap, 1.96e3 * gap_deviation, fmt=".", label="twin, 95 %")
panels[0].set_ylabel("gap [um]")
panels[0].legend()
panels[1].plot(steps, true_force, "k")
panels[1].errorbar(steps, found_force, 1.96 * force_deviation, fmt=".")
panels[1].set_ylabel(f"contact force [{model.force_unit}]")
panels[1].set_xlabel("step")
for axes in panels:
    axes.axvspan(N_STEPS // 2 - 0.5, N_STEPS // 2 + 2.5, color="0.9")
figure.savefig(RESULTS / "twin.png", dpi=150)
