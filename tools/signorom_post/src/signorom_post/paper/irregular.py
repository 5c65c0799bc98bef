# SPDX-License-Identifier: BSD-3-Clause
"""Figures 19 to 22: models from scattered snapshots (the paper: "irregular"), without and with three clusters."""

import numpy as np

from signorom_post.forest import features_of, fit, read_labels
from signorom_post.paper import published
from signorom_post.paper.clusters import N_CLUSTERS
from signorom_post.paper.comparison import Comparison, count, percent
from signorom_post.paper.domains import domains_of_clusters
from signorom_post.paper.maps import TEXTS, error_map_of, map_table, statistics
from signorom_post.paper.outcome import Outcome, Row, Study, history_of
from signorom_post.paper.variants import FOREST_SEED, FOREST_TREES, IRREGULAR, Variant
from signorom_post.plots.error_map import error_maps
from signorom_post.plots.partition import Partition, partition
from signorom_post.readers.model import Cluster, Model
from signorom_post.results import Results

#: key of DOMAINS: without clusters, the paper takes the same dual tolerance as for its largest domain
DOMAIN = 60
REMARK = (
    "the paper chooses its snapshots by a greedy algorithm, but does not give its criterion and candidates; ours are "
    "others, so the numbers need not agree, and nothing was tuned"
)
NUMBER_REMARK = (
    "pressure on whole edges makes only few different loads; if we have fewer snapshots than the paper, every "
    f"candidate is a combination of ours up to rounding; {REMARK}"
)
ORDER_REMARK = (
    "our clusters and the paper's are both numbered in ascending order of the number of contact pairs in their "
    f"domains; {REMARK}"
)


def figure_19(study: Study) -> Outcome:
    """Returns figure 19: maps of contact force errors of models from scattered snapshots, without clusters.

    The first model has no extra POD modes, the second one has some.
    """
    tolerances = {"FE": None, "POD + FE": published.IRREGULAR_TOLERANCE}
    kappa = published.MAX_CONDITION_NUMBER
    variants = [
        Variant(DOMAIN, kappa, extended_tolerance=tolerance, n_map=study.n_map, training=IRREGULAR)
        for tolerance in tolerances.values()
    ]
    table: list[Row] = []
    maps, found = [], []
    for text, n_columns, results in zip(
        tolerances, published.IRREGULAR_COLUMNS, study.runs.results(variants), strict=True
    ):
        history, sizes = history_of(results), results.report["reduction"]
        extra = int(history.n_columns[0]) - sizes["n_modes"]
        if text == "FE":
            found += [
                _number("Fig. 19", "modes l at 1e-6", published.IRREGULAR_MODES, sizes["n_modes"]),
                _number(
                    "Fig. 19", "contact pairs in the RID", published.IRREGULAR_ROWS, sizes["n_contact_rows"]
                ),
            ]
        else:
            found.append(_number("Fig. 19", "more modes at 3.5e-7", published.IRREGULAR_EXTRA, extra))
        ours = int(history.n_columns[-1])
        found.append(_number("Fig. 19", f"l-bar at kappa_max = 10, {text}", n_columns, ours))
        found += _map_numbers("Fig. 19", f"map, {text}", results)
        maps.append(error_map_of(results.validation, f"{text}: $\\bar{{\\ell}}$ = {ours}"))
        table += map_table(results, extra)
    return Outcome({"fig19": table}, {"fig19": error_maps(maps)}, found)


def figure_20(study: Study) -> Outcome:
    """Returns figure 20: the snapshots of each cluster, and a map of the cluster that the forest chooses."""
    results = _local_models(study)
    model, validation = results.model, results.validation
    clusters = by_rows(model)
    order = {int(cluster.name): i for i, cluster in enumerate(clusters)}
    _, points, labels = read_labels(results.folder / "labels.csv")
    forest = fit(features_of(points, points), labels, FOREST_TREES, FOREST_SEED)
    votes = np.sort(forest.predict_proba(features_of(validation.parameters, points)))
    answers = np.array([order[int(label)] for label in validation.columns["cluster"]])
    ratios = votes[:, -2] / votes[:, -1]
    shown = Partition(
        [model.training_points[cluster.training_points] for cluster in clusters],
        validation.parameters,
        answers,
        ratios,
    )
    table: list[Row] = [
        {"cluster": i, "P1_MPa": f"{point[0]:.6g}", "h1_mm": f"{point[1]:.6g}"}
        for i, members in enumerate(shown.members, start=1)
        for point in members
    ]
    box = [
        {
            "P1_MPa": f"{point[0]:.6g}",
            "h1_mm": f"{point[1]:.6g}",
            "cluster": answer + 1,
            "second_over_first": ratio,
        }
        for point, answer, ratio in zip(validation.parameters, answers, ratios, strict=True)
    ]
    n_points = len(model.training_points)
    found = [_number("Fig. 20", "snapshots", published.N_IRREGULAR, n_points, NUMBER_REMARK)]
    return Outcome({"fig20a": table, "fig20b": box}, {"fig20": partition(shown)}, found)


def figure_21(study: Study) -> Outcome:
    """Returns figure 21: the reduced integration domain of each cluster."""
    results = _local_models(study)
    papers = published.IRREGULAR_CLUSTERS
    return domains_of_clusters("Fig. 21", results, by_rows(results.model), papers, ORDER_REMARK)


def figure_22(study: Study) -> Outcome:
    """Returns figure 22: the map of the errors of the contact forces with three clusters."""
    results = _local_models(study)
    sizes = [cluster.n_modes for cluster in by_rows(results.model)]
    title = f"three clusters: $\\bar{{\\ell}}$ = {', '.join(map(str, sizes))}"
    found = [
        _number("Fig. 22", f"l-bar of cluster {i} at kappa_max = 10", paper.n_columns, size, ORDER_REMARK)
        for i, (size, paper) in enumerate(zip(sizes, published.IRREGULAR_CLUSTERS, strict=True), start=1)
    ]
    found += _map_numbers("Fig. 22", "map, three clusters", results)
    return Outcome(
        {"fig22": map_table(results, 0)},
        {"fig22": error_maps([error_map_of(results.validation, title)])},
        found,
    )


def by_rows(model: Model) -> list[Cluster]:
    """Returns the clusters in ascending order of the number of contact pairs in their domains."""
    return sorted(model.clusters, key=lambda cluster: len(cluster.contact_rows))


def _local_models(study: Study) -> Results:
    """Returns the results of three clusters at kappa_max = 10, with the model and an error map."""
    kappa = published.MAX_CONDITION_NUMBER
    variant = Variant(
        None, kappa, n_clusters=N_CLUSTERS, n_map=study.n_map, has_fields=True, training=IRREGULAR
    )
    return study.runs.results([variant])[0]


def _number(where: str, quantity: str, paper: int, ours: int, remark: str = REMARK) -> Comparison:
    return Comparison(where, quantity, paper, ours, count, is_robust=False, remark=remark)


def _map_numbers(where: str, what: str, results: Results) -> list[Comparison]:
    """Returns our statistics of a map. The paper's maps are pictures, so there are no numbers to compare with."""
    ours = statistics(results.validation)
    return [
        Comparison(where, f"{what}: {text}", None, getattr(ours, key), percent, remark=REMARK)
        for key, text in TEXTS.items()
    ]
