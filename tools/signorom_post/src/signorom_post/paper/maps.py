# SPDX-License-Identifier: BSD-3-Clause
"""Figures 11 and 13: maps of the dual error, without and with extra modes."""

import math

import numpy as np

from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, about, at_most, count, percent
from signorom_post.paper.convergence import RANK_REMARK
from signorom_post.paper.outcome import Outcome, Row, Study, history_of, strategy_text
from signorom_post.paper.variants import Variant
from signorom_post.plots.error_map import ErrorMap, error_maps
from signorom_post.readers.validation import Validation
from signorom_post.results import Results

#: allowed difference in the size of the basis at kappa_max
MARGIN = 8
#: statistics of a map may be up to this factor times the reference
FACTOR = 1.3
#: attribute of MapStatistics -> its name in the table
TEXTS = {"median": "median of the dual error", "p95": "95th percentile", "above_10": "points above 10 %"}
#: solver in validation.csv at a point whose reduced problem has no solution: the full-order operator answered
FULL_ORDER_METHOD = "condensed"
REFERENCE_REMARK = (
    "the paper prints its maps as pictures; the number beside ours is of an independent NumPy code on 40 x 40 "
    "points"
)


def figure_11(study: Study) -> Outcome:
    """Returns figure 11: maps of the errors of the contact forces, without and with extra POD modes.

    The reduced domain is the one that has 34 contact pairs in the paper.
    """
    return _maps(study, "fig11", 34)


def figure_13(study: Study) -> Outcome:
    """Returns figure 13: maps of the errors of the contact forces, without and with extra POD modes.

    The reduced domain is the one that has 60 contact pairs in the paper.
    """
    outcome = _maps(study, "fig13", 60)
    variant = Variant(60, published.MAX_CONDITION_NUMBER, n_map=study.n_map)
    history = history_of(study.runs.results([variant])[0])
    solvable = history.first_solvable()
    outcome.comparisons.append(
        Comparison(
            "Fig. 13",
            "l-bar where (11) holds first, FE",
            published.ENRICHMENT[60].n_columns_solvable,
            math.nan if solvable is None else history.n_columns[solvable],
            count,
            is_robust=False,
            remark=RANK_REMARK,
        )
    )
    return outcome


def statistics(validation: Validation) -> published.MapStatistics:
    """Returns the statistics of the dual error on the reduced domain.

    These are the median, the 95 % quantile, and the share of points with an error above 10 %. Quantiles are errors of
    points, without interpolation. A point counts only if its error is not nan, and at least one point must count. The
    error is nan where neither model has a contact force in the domain, or where the full-order model has no solution.
    """
    error = validation.columns["e_lambda_rid"]
    error = error[~np.isnan(error)]
    median, p95 = np.quantile(error, [0.5, 0.95], method="inverted_cdf")
    return published.MapStatistics(float(median), float(p95), float(np.mean(error > 0.1)))


def _maps(study: Study, name: str, domain: int) -> Outcome:
    extras = (0, published.EXTRA_MODES)
    kappa = published.MAX_CONDITION_NUMBER
    variants = [Variant(domain, kappa, extra_modes=e, n_map=study.n_map) for e in extras]
    variants += [Variant(domain, kappa, extra_modes=e, load="cut") for e in extras]
    all_results = study.runs.results(variants)
    found, cut = all_results[:2], all_results[2:]
    table: list[Row] = []
    maps, comparisons = [], []
    for extra, results, results_cut, n_columns in zip(
        extras, found, cut, published.ENRICHMENT[domain].n_columns, strict=True
    ):
        text = strategy_text(extra)
        ours = int(history_of(results).n_columns[-1])
        comparisons.append(
            Comparison(
                f"Fig. {name[3:]}",
                f"l-bar at kappa_max = 10, {text}",
                n_columns,
                ours,
                count,
                about(n_columns, MARGIN),
                cut=int(history_of(results_cut).n_columns[-1]),
            )
        )
        comparisons += _map_comparisons(name, domain, extra, results.validation)
        maps.append(error_map_of(results.validation, f"{text}: $\\bar{{\\ell}}$ = {ours}"))
        table += map_table(results, extra)
    return Outcome({name: table}, {name: error_maps(maps)}, comparisons)


def _map_comparisons(name: str, domain: int, extra: int, validation: Validation) -> list[Comparison]:
    ours = statistics(validation)
    n_answered = validation.solvers.count(FULL_ORDER_METHOD)
    remark = REFERENCE_REMARK
    if n_answered:
        remark += (
            f"; {n_answered} points have no reduced solution, and the full order answers there without error"
        )
    reference = published.REFERENCE_MAPS[domain, extra]
    return [
        Comparison(
            f"Fig. {name[3:]}",
            f"map, {strategy_text(extra)}: {text}",
            getattr(reference, key),
            getattr(ours, key),
            percent,
            at_most(getattr(reference, key), FACTOR),
            remark=remark,
            is_published=False,
        )
        for key, text in TEXTS.items()
    ]


def error_map_of(validation: Validation, title: str) -> ErrorMap:
    """Returns the map of the dual error on the reduced domain, with its statistics below the title."""
    ours = statistics(validation)
    spread = f"median {percent(ours.median)}, 95 %: {percent(ours.p95)}, above 10 %: {percent(ours.above_10)}"
    return ErrorMap(
        title=f"{title}\n{spread}",
        x=validation.parameters[:, 0],
        y=validation.parameters[:, 1],
        errors=validation.columns["e_lambda_rid"],
    )


def map_table(results: Results, extra: int) -> list[Row]:
    """Returns one row per test point with errors, numbers of active contacts, and the solver.

    `extra`, the number of extra modes of the model, is written into each row.
    """
    validation = results.validation
    names = ("e_u", "e_lambda_rid", "e_lambda_all", "n_active", "n_active_full_order")
    return [
        {
            "extra_modes": extra,
            "P1_MPa": f"{point[0]:.6g}",
            "h1_mm": f"{point[1]:.6g}",
            **{name: validation.columns[name][i] for name in names},
            "solver": validation.solvers[i],
        }
        for i, point in enumerate(validation.parameters)
    ]
