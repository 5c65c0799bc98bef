# SPDX-License-Identifier: BSD-3-Clause
"""Reads snapshots.h5: the full-order solutions at the training points."""

from dataclasses import dataclass
from pathlib import Path

from signorom_post.arrays import FloatArray, IntArray, Quantity
from signorom_post.readers.hdf5_input import Hdf5Input


@dataclass(frozen=True)
class SnapshotSet:
    """The full-order solutions at m training points, one row per point."""

    path: Path
    #: checksum that identifies the mechanical problem
    provenance: str
    parameter_names: list[str]
    #: values of the parameters, shape (m, n_parameters)
    parameters: FloatArray
    #: [length] shape (m, n_dofs), or (m, 0) if a condensed model needs contact forces only
    displacement: Quantity
    #: contact forces [force, or force per length], shape (m, n_multipliers)
    multipliers: Quantity
    #: steps of the solver, shape (m)
    iterations: IntArray
    #: > 0 converged, < 0 failed; shape (m)
    reasons: IntArray
    #: errors of equilibrium, penetration, negative contact force, complementarity, balance of forces; shape (m, 5)
    residuals: FloatArray
    #: wall time of each solution [s], shape (m)
    seconds: FloatArray


def read_snapshots(path: Path) -> SnapshotSet:
    """Returns the contents of snapshots.h5; InputError if the file is missing, damaged or inconsistent."""
    with Hdf5Input(path) as file:
        file.check_format("signorom snapshots", 2)
        names = file.texts("/parameter_names")
        parameters = file.reals("/parameters", 2)
        if parameters.shape[1] != len(names):
            raise file.fail(
                f"'/parameters' has {parameters.shape[1]} columns for {len(names)} parameter names"
            )
        result = SnapshotSet(
            path=path,
            provenance=str(file.attribute("/", "provenance") or ""),
            parameter_names=names,
            parameters=parameters,
            displacement=Quantity(file.reals("/displacement", 2), file.unit("/displacement")),
            multipliers=Quantity(file.reals("/multipliers", 2), file.unit("/multipliers")),
            iterations=file.integers("/iterations"),
            reasons=file.integers("/reasons"),
            residuals=file.reals("/residuals", 2),
            seconds=file.reals("/seconds", 1),
        )
        rows = {
            "displacement": len(result.displacement.values),
            "multipliers": len(result.multipliers.values),
            "iterations": len(result.iterations),
            "reasons": len(result.reasons),
            "residuals": len(result.residuals),
            "seconds": len(result.seconds),
        }
        for name, n_rows in rows.items():
            if n_rows != len(parameters):
                raise file.fail(f"'/{name}' has {n_rows} rows for {len(parameters)} points")
    return result
