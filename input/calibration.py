# SPDX-License-Identifier: BSD-3-Clause
# %% [markdown]
# # Calibration of a fuel rod
#
# Strain gauges on the cladding of the rod in `fuel_rod.yaml` have measured 30 load states. Which gap, which Young's
# modulus and which Poisson's ratio of the cladding explain them, and how well are these known?
#
# The reduced model answers a load state in about a millisecond, with derivatives in a few, so a least-squares fit takes
# seconds, and a Monte Carlo study with 100 000 answers a minute or two.
#
# Train the model first, then run this file as a program, or cell by cell in an editor that knows `# %%`:
#
#     signorom run input/fuel_rod.yaml
#     pip install 'tools/signorom_post[examples]'
#     python input/calibration.py

# %%
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from signorom_post import Model

PROGRAM = os.environ.get("SIGNOROM_EXECUTABLE", "signorom")
DECK = Path("input/fuel_rod.yaml")
RESULTS = Path("results/calibration")
N_STATES = 30  # load states
N_DRAWS = 3400  # of the Monte Carlo study, N_STATES answers each
NOISE = 1.0e-5  # standard deviation of a gauge's reading [-]
SEED = 14

rng = np.random.default_rng(SEED)
model = Model("results/fuel_rod/model.h5")
ranges = {parameter.name: (parameter.minimum, parameter.maximum) for parameter in model.parameters}
RESULTS.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## What is known, and what is looked for
#
# The pellet's constants are known from its data sheet. The loads of each state are known: linear power `q`, coolant
# pressure `P` and its height `h`.

# %%
KNOWN = {"E_fuel": 190.0e3, "nu_fuel": 0.30}
UNKNOWN = ["gap", "E_cladding", "nu_cladding"]  # mm, MPa, -
TRUTH = np.array([0.0137, 83.0e3, 0.36])  # what the measurement below is made with

LOADS = ["q", "P", "h"]
lower, upper = np.array([ranges[name] for name in LOADS]).T
states = qmc.scale(qmc.LatinHypercube(len(LOADS), seed=SEED).random(N_STATES), lower, upper)

# %% [markdown]
# ## Ten gauges, two directions each
#
# On the outer surface of the cladding, a gauge reads the hoop strain `u_r / r` at its node, and the axial strain between
# the nodes 0.3 mm below and above it.

# %%
tags, places = model.nodes
radius = places[:, 0].max()
outside = np.flatnonzero(np.isclose(places[:, 0], radius))
heights = np.linspace(0.8, 6.2, 10)
half_length = 0.3


def nodes_at(z):
    """Places among the model's nodes of those on the outside that are nearest to some heights."""
    return outside[abs(places[outside, 1] - np.asarray(z)[:, None]).argmin(axis=1)]


gauges = np.concatenate([nodes_at(heights), nodes_at(heights - half_length), nodes_at(heights + half_length)])
length = places[gauges[20:], 1] - places[gauges[10:20], 1]


def strains_of(displacement):
    """Hoop and axial strains from displacements of the gauges' nodes [..., 30, 2], shape [..., 20]."""
    hoop = displacement[..., :10, 0] / radius
    axial = (displacement[..., 20:, 1] - displacement[..., 10:20, 1]) / length
    return np.concatenate([hoop, axial], axis=-1)


# %% [markdown]
# ## The measurement
#
# There is no rod in this repository. The readings are full-order solutions at the true values, with noise: the model
# that is calibrated has no part in them.

# %%
columns = [*LOADS, *KNOWN, *UNKNOWN]
table = np.array([[*state, *KNOWN.values(), *TRUTH] for state in states])
order = [columns.index(name) for name in ranges]
points = RESULTS / "states.csv"
np.savetxt(points, table[:, order], "%.17g", ",", header=",".join(ranges), comments="")
lines = [line for line in DECK.read_text().splitlines() if not line.startswith(("training:", "test:"))]
deck = "\n".join([*lines, f"training: {{file: {points.resolve()}}}\n"])
mesh = DECK.parent / "../meshes/fuel_rod.msh"
measured = RESULTS / "measured.yaml"
measured.write_text(deck.replace("../meshes/fuel_rod.msh", str(mesh.resolve())))
subprocess.run([PROGRAM, "sample", measured], check=True, stdout=subprocess.DEVNULL)

with h5py.File("results/measured/snapshots.h5") as file:
    # the file keeps the points of earlier runs, too
    solved = file["parameters"][()]
    rows = [abs(solved - point).sum(axis=1).argmin() for point in table[:, order]]
    displacement = file["displacement"][()][rows].reshape(N_STATES, -1, 2)
readings = strains_of(displacement[:, gauges]) + NOISE * rng.standard_normal((N_STATES, 20))

# %% [markdown]
# ## What the model says, and how it changes with the unknowns


# %%
def answer_at(state, unknowns):
    """The model's answer at a load state."""
    values = dict(zip([*LOADS, *UNKNOWN], [*state, *unknowns], strict=True))
    return model.query(nodes=tags[gauges], **KNOWN, **values)


def misfits(unknowns):
    """(model - reading) / noise, shape (N_STATES * 20)."""
    strains = [strains_of(answer_at(state, unknowns).displacement) for state in states]
    return ((np.array(strains) - readings) / NOISE).ravel()


def slopes(unknowns):
    """Derivatives of the misfits, shape (N_STATES * 20, 3)."""
    chosen = [list(ranges).index(name) for name in UNKNOWN]
    gradients = [strains_of(answer_at(state, unknowns).gradient.displacement[chosen]) for state in states]
    return np.array(gradients).transpose(0, 2, 1).reshape(-1, len(UNKNOWN)) / NOISE


# %% [markdown]
# ## The fit
#
# From the middle of the ranges, by scipy with the derivatives of the model. The intervals are those of a normal
# distribution with the covariance matrix (J'J)^-1.

# %%
lowest, highest = np.array([ranges[name] for name in UNKNOWN]).T
fit = least_squares(
    misfits,
    (lowest + highest) / 2,
    jac=slopes,
    bounds=(lowest, highest),
    x_scale=highest - lowest,
    xtol=1e-10,
)
covariance = np.linalg.inv(fit.jac.T @ fit.jac)
deviation = np.sqrt(np.diag(covariance))
print(f"fit: {fit.nfev} evaluations, {fit.njev} with derivatives, {N_STATES} answers each")
print(f"misfit per reading: {np.sqrt(np.mean(fit.fun**2)):.3f} times the noise")

# %% [markdown]
# ## Monte Carlo
#
# The normal distribution is only as good as the model is linear, and contact is not. So draw values from a wider one,
# and give each its weight: how likely the readings are with it, over how often it is drawn.

# %%
wider = 1.5
draws = rng.multivariate_normal(fit.x, wider**2 * covariance, size=N_DRAWS)
draws = draws[((draws >= lowest) & (draws <= highest)).all(axis=1)]
with ThreadPoolExecutor() as pool:
    squares = np.array(list(pool.map(lambda values: np.sum(misfits(values) ** 2), draws)))
away = np.linalg.solve(np.linalg.cholesky(covariance), (draws - fit.x).T) / wider
logarithms = -squares / 2 + np.sum(away**2, axis=0) / 2
weights = np.exp(logarithms - logarithms.max())
weights /= weights.sum()
print(f"Monte Carlo: {N_STATES * len(draws)} answers, worth {1 / np.sum(weights**2):.0f} equal draws")


def quantiles(values, shares=(0.025, 0.975)):
    """Of the weighted draws."""
    order = np.argsort(values)
    return np.interp(shares, np.cumsum(weights[order]), values[order])


# %% [markdown]
# ## Values and their intervals of 95 %
#
# One interval in twenty misses the true value: that is what 95 % means.

# %%
print(f"{'':12}{'truth':>12}{'fit':>12}{'interval of the fit':>26}{'Monte Carlo':>26}")
for k, name in enumerate(UNKNOWN):
    ends = fit.x[k] + 1.96 * deviation[k] * np.array([-1, 1])
    drawn = quantiles(draws[:, k])
    print(
        f"{name:12}{TRUTH[k]:12.6g}{fit.x[k]:12.6g}"
        f"{ends[0]:13.6g}{ends[1]:13.6g}{drawn[0]:13.6g}{drawn[1]:13.6g}"
    )

# %% [markdown]
# ## Pictures
#
# Readings against the fit: what is left must look like noise.

# %%
figure, panels = plt.subplots(1, 2, figsize=(11, 5), layout="constrained")
left_over = fit.fun.reshape(readings.shape)
for columns, label in [(slice(0, 10), "hoop strain"), (slice(10, 20), "axial strain")]:
    read = readings[:, columns]
    panels[0].plot(1e6 * read.ravel(), 1e6 * (read + NOISE * left_over[:, columns]).ravel(), ".", label=label)
    panels[1].plot(1e6 * read.ravel(), left_over[:, columns].ravel(), ".", label=label)
panels[0].axline((0, 0), slope=1, color="black", linewidth=0.8)
panels[0].set_ylabel("model after the fit [1e-6]")
panels[0].legend()
panels[1].set_ylabel("(model - reading) / noise")
for axes in panels:
    axes.set_xlabel("reading [1e-6]")
figure.savefig(RESULTS / "readings.png", dpi=150)

# %% [markdown]
# The unknowns in pairs: ellipses hold 95 % of the normal distribution, dots are draws, their size is their weight.

# %%
figure, panels = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
angles = np.linspace(0, 2 * np.pi, 200)
circle = np.sqrt(5.991) * np.array([np.cos(angles), np.sin(angles)])
for axes, (i, k) in zip(panels, [(0, 1), (0, 2), (1, 2)], strict=True):
    pair = np.ix_([i, k], [i, k])
    ellipse = fit.x[[i, k], None] + np.linalg.cholesky(covariance[pair]) @ circle
    axes.scatter(draws[:, i], draws[:, k], s=6 * weights / weights.max(), color="tab:blue", linewidths=0)
    axes.plot(*ellipse, color="tab:orange", label="fit, 95 %")
    axes.plot(TRUTH[i], TRUTH[k], "k+", markersize=10, label="truth")
    axes.set_xlabel(UNKNOWN[i])
    axes.set_ylabel(UNKNOWN[k])
panels[0].legend()
figure.savefig(RESULTS / "unknowns.png", dpi=150)

# %% [markdown]
# ## What it means for the rod
#
# The resultant of the contact at full power and full coolant pressure, with what is known now.

# %%
full = [ranges["q"][1], ranges["P"][1], ranges["h"][1]]
with ThreadPoolExecutor() as pool:
    forces = np.array(list(pool.map(lambda values: answer_at(full, values).contact_force, draws)))
true_force = answer_at(full, TRUTH).contact_force
ends = quantiles(forces)
print(
    f"contact force at full power: {ends[0]:.4g} to {ends[1]:.4g} {model.force_unit}, truth {true_force:.4g}"
)
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.hist(forces, bins=60, weights=weights, color="tab:blue")
axes.axvline(true_force, color="black", label="with the true values")
axes.axvline(ends[0], color="tab:orange", label="95 %")
axes.axvline(ends[1], color="tab:orange")
axes.set_xlabel(f"contact force [{model.force_unit}]")
axes.set_yticks([])
axes.legend()
figure.savefig(RESULTS / "contact_force.png", dpi=150)
