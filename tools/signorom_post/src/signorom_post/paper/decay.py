# SPDX-License-Identifier: BSD-3-Clause
"""Figure 16: approximation error (20) of all snapshots, and of the snapshots of each of the three clusters."""

from signorom_post.paper import published
from signorom_post.paper.clusters import by_height, local_bases
from signorom_post.paper.comparison import Comparison, count, exactly, number
from signorom_post.paper.outcome import Outcome, Row, Study
from signorom_post.paper.variants import Variant
from signorom_post.plots.singular_values import Decay, decays, energy_tail, kept_modes


def figure_16(study: Study) -> Outcome:
    """Returns figure 16: singular values and energy tails of all snapshots and of three clusters.

    It compares the number of snapshots and the number of modes with the paper's, and the energy tails beyond the extra
    modes of Table 1 with the paper's tolerances.
    """
    (results,), (results_cut,) = study.both_loads([Variant(34, 1.0, has_fields=True)])
    model, model_cut = results.model, results_cut.model
    cluster, cluster_cut = model.clusters[0], model_cut.clusters[0]
    tail, tail_cut = energy_tail(cluster.singular_values), energy_tail(cluster_cut.singular_values)
    local = local_bases(study).model
    curves = [
        Decay(cluster.singular_values, kept_modes(cluster, model.pod_tolerance), model.pod_tolerance, "all: ")
    ]
    curves += [
        Decay(
            part.singular_values, kept_modes(part, local.pod_tolerance), local.pod_tolerance, f"cluster {i}: "
        )
        for i, part in enumerate(by_height(local), start=1)
    ]
    n_modes = kept_modes(cluster, model.pod_tolerance)
    n_points = len(model.training_points)
    comparisons = [
        Comparison(
            "Fig. 16", "snapshots", published.N_SNAPSHOTS, n_points, count, exactly(published.N_SNAPSHOTS)
        ),
        Comparison(
            "Fig. 16",
            "modes l at 1e-6",
            published.N_MODES,
            n_modes,
            count,
            exactly(published.N_MODES),
            cut=kept_modes(cluster_cut, model_cut.pod_tolerance),
        ),
    ]
    comparisons += [
        Comparison(
            "Table 1",
            f"energy tail behind l + {row.extra_modes} modes",
            row.tolerance,
            tail[published.N_MODES + row.extra_modes],
            number,
            cut=tail_cut[published.N_MODES + row.extra_modes],
            remark="the paper gives a tolerance, which lies above the tail",
        )
        for row in published.TABLE_1
        if row.tolerance is not None
    ]
    return Outcome({"fig16": _table(curves)}, {"fig16": decays(curves)}, comparisons)


def _table(curves: list[Decay]) -> list[Row]:
    """Returns a row per number of modes, from 0, with singular value and energy tail of each curve.

    The first curve is that of all snapshots. The cells of a cluster are empty beyond its number of singular values.
    """
    names = ["", *(f"_of_cluster_{i}" for i in range(1, len(curves)))]
    table: list[Row] = [{"modes": i} for i in range(len(curves[0].singular_values) + 1)]
    for name, curve in zip(names, curves, strict=True):
        tail = energy_tail(curve.singular_values)
        for i, row in enumerate(table):
            row[f"singular_value{name}"] = curve.singular_values[i - 1] if 0 < i < len(tail) else ""
            row[f"energy_tail{name}"] = tail[i] if i < len(tail) else ""
    return table
