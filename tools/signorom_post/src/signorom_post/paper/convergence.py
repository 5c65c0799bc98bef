# SPDX-License-Identifier: BSD-3-Clause
"""Figures 3 and 10: errors at the point of strong contact while hat functions are added to the basis."""

import math

import numpy as np

from signorom_post.arrays import FloatArray
from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, count, number, percent
from signorom_post.paper.outcome import Outcome, Row, Study, errors_at, history_of, strategy_text
from signorom_post.paper.variants import STRONG, WEAK, Variant
from signorom_post.plots.enrichment_errors import ErrorSeries, errors_and_kappa, errors_and_size
from signorom_post.readers.enrichment import History

DOMAIN = 34
RANK_REMARK = (
    "whether the contact rows count as independent depends on the rank tolerance, which the paper does not "
    "give; here a singular value counts as zero below 1e-10 of the largest"
)


def figure_3(study: Study) -> Outcome:
    """Returns figure 3: errors of contact forces and of displacements over kappa, at the point of strong contact.

    The reduced domain is the one that has 34 contact pairs in the paper, and the basis has no extra modes. The table of
    the figure also has the errors at the point of weak contact.
    """
    history, rows = _series(study, 0)
    series = _error_series(history, rows, 0)
    return Outcome({"fig03": rows}, {"fig03": errors_and_kappa(series)})


def figure_10(study: Study) -> Outcome:
    """Returns figure 10, its table and comparisons with the paper: errors of contact forces over basis size and kappa.

    The figure shows the point of strong contact, with a curve without and a curve with extra POD modes, on the same
    reduced domain as figure 3. Its table also has the errors at the point of weak contact.
    """
    extras = (0, published.EXTRA_MODES)
    found = {extra: _series(study, extra) for extra in extras}
    series = [_error_series(history, rows, extra) for extra, (history, rows) in found.items()]
    table = [row for _, rows in found.values() for row in rows]
    comparisons = _comparisons(*found[0])
    return Outcome({"fig10": table}, {"fig10": errors_and_size(series)}, comparisons)


def _series(study: Study, extra: int) -> tuple[History, list[Row]]:
    """Returns the whole enrichment with `extra` modes, and a row of errors before the first and after each hat."""
    whole = Variant(DOMAIN, 1.0, extra_modes=extra)
    history = history_of(study.runs.results([whole])[0])
    parts = [Variant(DOMAIN, 1.0, max_hats=k, extra_modes=extra) for k in range(history.n_hats)]
    rows: list[Row] = []
    for k, results in enumerate(study.runs.results([*parts, whole])):
        strong, weak = errors_at(results, STRONG), errors_at(results, WEAK)
        rows.append(
            {
                "extra_modes": extra,
                "hats": k,
                "n_columns": int(history.n_columns[k]),
                "rank": int(history.ranks[k]),
                "condition_number": history.condition_numbers[k],
                "singular_ratio": history.singular_ratios[k],
                "stiffness_condition": history.stiffness_conditions[k],
                "e_u_170_3.2": strong[0],
                "e_lambda_170_3.2": strong[1],
                "e_u_30_5.25": weak[0],
                "e_lambda_30_5.25": weak[1],
                "solver_170_3.2": results.validation.solvers[0],
            }
        )
    return history, rows


def _error_series(history: History, rows: list[Row], extra: int) -> ErrorSeries:
    return ErrorSeries(
        label=f"$\\ell + {extra}$" if extra else "$\\ell$",
        sizes=history.n_columns,
        condition_numbers=history.condition_numbers,
        primal=_column(rows, "e_u_170_3.2"),
        dual=_column(rows, "e_lambda_170_3.2"),
        first_solvable=history.first_solvable(),
    )


def _column(rows: list[Row], name: str) -> FloatArray:
    return np.array([row[name] for row in rows], dtype=np.float64)


def _comparisons(history: History, rows: list[Row]) -> list[Comparison]:
    paper = published.ENRICHMENT[DOMAIN]
    solvable = history.first_solvable()
    at_10 = history.first_below(published.MAX_CONDITION_NUMBER)
    dual = _column(rows, "e_lambda_170_3.2")
    text = strategy_text(0)
    return [
        Comparison(
            "Fig. 10",
            f"l-bar where (11) holds first, {text}",
            paper.n_columns_solvable,
            math.nan if solvable is None else history.n_columns[solvable],
            count,
            is_robust=False,
            remark=RANK_REMARK,
        ),
        Comparison(
            "Fig. 10",
            "kappa with 4 hats (l-bar 40), FE; paper: above 1000",
            1000.0,
            history.condition_numbers[4],
            number,
            is_robust=False,
        ),
        Comparison(
            "Fig. 10",
            "dual error with 4 hats, FE; paper: above 70 %",
            0.70,
            dual[4],
            percent,
            is_robust=False,
        ),
        Comparison(
            "Fig. 10",
            "dual error at kappa_max = 10, FE",
            published.DUAL_ERROR_AT_10,
            math.nan if at_10 is None else dual[at_10],
            percent,
        ),
    ]
