# SPDX-License-Identifier: BSD-3-Clause
"""Figures 15, 17 and 18 and Table 2: three local models from snapshots on a grid (the paper: "regular")."""

import numpy as np

from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, about, at_most, count, number, percent
from signorom_post.paper.domains import domains_of_clusters
from signorom_post.paper.maps import TEXTS, error_map_of, map_table, statistics
from signorom_post.paper.outcome import Outcome, Row, Study, errors_at, point_text
from signorom_post.paper.variants import POINTS, Variant
from signorom_post.plots.cluster_map import ClusterMap, cluster_map
from signorom_post.plots.error_map import error_maps
from signorom_post.readers.model import Cluster, Model
from signorom_post.results import Results

N_CLUSTERS = 3
#: allowed differences from the paper: in the snapshots of a cluster, and in the size of its basis
SNAPSHOTS_MARGIN, COLUMNS_MARGIN = 20, 8
#: errors of the contact forces with a hat on every contact pair may be up to this factor times the paper's
FACTOR = 1.3
#: kappa_max -> upper limits of the map with three clusters. The paper shows a map at 10 as a picture, and none at 1
MAP_LIMITS = {
    published.MAX_CONDITION_NUMBER: published.MapStatistics(0.04, 0.18, 0.12),
    1.0: published.MapStatistics(0.015, None, 0.04),
}
KAPPA_REMARK = (
    "with fewer modes than contact pairs, kappa by equation (11) is infinite, for the paper's sizes too; the numbers "
    "are ratios of the largest to the smallest singular value that is not zero"
)
BORDER_REMARK = "the borders of the clusters, and with them all sizes, depend on ties between grid cells"
MAP_REMARK = (
    "the paper shows the map at kappa_max = 10 only as a picture, and no map at 1; the limits are agreed ones, not the "
    "paper's"
)


def _local_models(study: Study) -> Results:
    """Returns the results of three clusters at kappa_max = 10, with the model and an error map."""
    kappa = published.MAX_CONDITION_NUMBER
    variant = Variant(None, kappa, n_clusters=N_CLUSTERS, n_map=study.n_map, has_fields=True)
    return study.runs.results([variant])[0]


def local_bases(study: Study) -> Results:
    """Returns the results of three clusters with a hat on every contact pair and without an error map, as in Table 2."""
    return study.runs.results([Variant(None, 1.0, n_clusters=N_CLUSTERS, has_fields=True)])[0]


def by_height(model: Model) -> list[Cluster]:
    """Returns the clusters in descending order of h1, the height of the load, as mean over their snapshots."""
    return sorted(
        model.clusters, key=lambda cluster: -model.training_points[cluster.training_points, 1].mean()
    )


def figure_15(study: Study) -> Outcome:
    """Returns figure 15: the snapshots of each cluster, and a map of the cluster that is chosen at each test point.

    The numbers of snapshots are compared with the paper's.
    """
    results = _local_models(study)
    model, validation = results.model, results.validation
    clusters = by_height(model)
    order = {int(cluster.name): i for i, cluster in enumerate(clusters)}
    shown = ClusterMap(
        x=validation.parameters[:, 0],
        y=validation.parameters[:, 1],
        labels=np.array([order[int(label)] for label in validation.columns["cluster"]]),
        members=[model.training_points[cluster.training_points] for cluster in clusters],
    )
    table: list[Row] = [
        {"cluster": i, "P1_MPa": f"{point[0]:.6g}", "h1_mm": f"{point[1]:.6g}"}
        for i, members in enumerate(shown.members, start=1)
        for point in members
    ]
    comparisons = [
        Comparison(
            "Fig. 15",
            f"snapshots of cluster {i}",
            paper.n_snapshots,
            len(cluster.training_points),
            count,
            about(paper.n_snapshots, SNAPSHOTS_MARGIN),
            is_robust=False,
            remark=BORDER_REMARK,
        )
        for i, (cluster, paper) in enumerate(zip(clusters, published.CLUSTERS, strict=True), start=1)
    ]
    return Outcome({"fig15": table}, {"fig15": cluster_map(shown)}, comparisons)


def figure_17(study: Study) -> Outcome:
    """Returns figure 17: the reduced integration domain of each cluster, a picture and a table for each.

    The numbers of modes and of contact pairs are compared with the paper's.
    """
    results = _local_models(study)
    return domains_of_clusters("Fig. 17", results, by_height(results.model), published.CLUSTERS)


def table_2(study: Study) -> Outcome:
    """Returns table 2: the errors at the two points of Table 1, with three clusters and a hat on every contact pair.

    A row also has, for the cluster that was chosen at its point, the ratio of the largest to the smallest nonzero
    singular value of the contact rows before the hats (compared with the paper's kappa), and the sizes of the basis
    before and after the hats. The paper's numbers stand beside ours.
    """
    results = local_bases(study)
    validation = results.validation
    table: list[Row] = []
    comparisons: list[Comparison] = []
    for point, paper in zip(POINTS, published.TABLE_2, strict=True):
        row = int(np.argmin(np.abs(validation.parameters - np.array(point)).sum(axis=1)))
        label = int(validation.columns["cluster"][row])
        history = next(item for item in results.enrichment if item.cluster == label)
        primal, dual = errors_at(results, point)
        text = f"at {point_text(point)}"
        n_modes, n_columns = history.n_columns[0], history.n_columns[-1]
        kappa = history.singular_ratios[0]
        table.append(
            {
                "P1_MPa": point[0],
                "h1_mm": point[1],
                "condition_number_paper": paper.condition_number,
                "condition_number": kappa,
                "n_modes_paper": paper.n_modes,
                "n_modes": int(n_modes),
                "n_columns_paper": paper.n_columns,
                "n_columns": int(n_columns),
                "e_u_paper": paper.primal,
                "e_u": primal,
                "e_lambda_paper": paper.dual,
                "e_lambda": dual,
            }
        )
        loose = {"is_robust": False, "remark": BORDER_REMARK}
        comparisons += [
            Comparison(
                "Table 2",
                f"kappa before the hats {text}",
                paper.condition_number,
                kappa,
                number,
                is_robust=False,
                remark=KAPPA_REMARK,
            ),
            Comparison("Table 2", f"modes l {text}", paper.n_modes, n_modes, count, **loose),
            Comparison("Table 2", f"final l-bar {text}", paper.n_columns, n_columns, count, **loose),
            Comparison("Table 2", f"primal error {text}", paper.primal, primal, percent),
            Comparison(
                "Table 2", f"dual error {text}", paper.dual, dual, percent, at_most(paper.dual, FACTOR)
            ),
        ]
    return Outcome({"table2": table}, {}, comparisons)


def figure_18(study: Study) -> Outcome:
    """Returns figure 18: maps of the errors of the contact forces with three clusters, at kappa_max = 10 and 1.

    The sizes of the bases at kappa_max = 10 are compared with the paper's, the errors of both maps with agreed limits.
    """
    results = _local_models(study)
    order = by_height(results.model)
    sizes = [int(cluster.n_modes) for cluster in order]
    comparisons = [
        Comparison(
            "Fig. 18",
            f"l-bar of cluster {i} at kappa_max = 10",
            paper.n_columns,
            size,
            count,
            about(paper.n_columns, COLUMNS_MARGIN),
        )
        for i, (size, paper) in enumerate(zip(sizes, published.CLUSTERS, strict=True), start=1)
    ]
    all_hats = study.runs.results([Variant(None, 1.0, n_clusters=N_CLUSTERS, n_map=study.n_map)])[0]
    last = {history.cluster: int(history.n_columns[-1]) for history in all_hats.enrichment}
    sizes_of = {published.MAX_CONDITION_NUMBER: sizes, 1.0: [last[int(cluster.name)] for cluster in order]}
    table: list[Row] = []
    maps = []
    for (kappa, limits), found in zip(MAP_LIMITS.items(), (results, all_hats), strict=True):
        text = f"$\\kappa_{{\\mathrm{{max}}}}$ = {kappa:g}: $\\bar{{\\ell}}$ = {', '.join(map(str, sizes_of[kappa]))}"
        maps.append(error_map_of(found.validation, text))
        table += [{"max_condition_number": kappa} | row for row in map_table(found, 0)]
        comparisons += _map_comparisons(kappa, limits, statistics(found.validation))
    return Outcome({"fig18": table}, {"fig18": error_maps(maps)}, comparisons)


def _map_comparisons(
    kappa: float, limits: published.MapStatistics, ours: published.MapStatistics
) -> list[Comparison]:
    found = []
    for key, text in TEXTS.items():
        limit = getattr(limits, key)
        found.append(
            Comparison(
                "Fig. 18",
                f"map at kappa_max = {kappa:g}: {text}",
                limit,
                getattr(ours, key),
                percent,
                None if limit is None else at_most(limit, 1.0),
                remark=MAP_REMARK,
                is_published=limit is None,
            )
        )
    return found
