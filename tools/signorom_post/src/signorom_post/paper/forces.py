# SPDX-License-Identifier: BSD-3-Clause
"""Figure 14: contact forces of the full-order and the reduced models at the point of strong contact."""

import numpy as np

from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, at_most, percent
from signorom_post.paper.outcome import Outcome, Row, Study, errors_at, point_text
from signorom_post.paper.variants import STRONG, Variant
from signorom_post.plots.contact_forces import ContactForces, contact_forces
from signorom_post.readers.fields import FieldPoint
from signorom_post.results import Results

DOMAINS = (34, 60)
#: dual errors may be up to this factor times the paper's, as for the same models in Table 1
FACTOR = 1.3


def figure_14(study: Study) -> Outcome:
    """Returns figure 14: contact forces at 170 MPa and 3.2 mm, at full order and of two reduced models.

    In the paper, the reduced domains of the two models have 34 and 60 contact pairs; ours may have a few more or less.
    Both models have a hat on every contact pair (kappa_max = 1).
    """
    found, cut = study.both_loads([Variant(domain, 1.0, has_fields=True) for domain in DOMAINS])
    table: list[Row] = []
    panels, comparisons = [], []
    for domain, results, results_cut in zip(DOMAINS, found, cut, strict=True):
        error, error_cut = (errors_at(item, STRONG)[1] for item in (results, results_cut))
        forces = _forces(results, domain, error)
        panels.append(forces)
        table += _table(forces, domain)
        paper = published.ENRICHMENT[domain].dual_error
        comparisons.append(
            Comparison(
                "Fig. 14",
                f"dual error at {point_text(STRONG)}, {domain} pairs, all hats",
                paper,
                error,
                percent,
                at_most(paper, FACTOR),
                cut=error_cut,
            )
        )
    return Outcome({"fig14": table}, {"fig14": contact_forces(panels)}, comparisons)


def _forces(results: Results, domain: int, error: float) -> ContactForces:
    fields = results.fields
    point = _point(results)
    height = fields.mesh.coordinates[fields.contact.owners, 1]
    rows = point.reduced_rows
    full = fields.field(point, "multipliers_full_order")
    return ContactForces(
        title=f"$N_\\lambda^C$ = {len(rows)} (paper {domain}): error {percent(error)}",
        position=height,
        full_order=full.values,
        reduced_position=height[rows],
        reduced=fields.field(point, "multipliers_reduced").values[rows],
        force_unit=full.unit,
        length_unit=fields.mesh.unit,
    )


def _point(results: Results) -> FieldPoint:
    return next(point for point in results.fields.points if np.allclose(point.parameters, STRONG))


def _table(forces: ContactForces, domain: int) -> list[Row]:
    reduced = dict(zip(forces.reduced_position.tolist(), forces.reduced.tolist(), strict=True))
    return [
        {
            "pairs_paper": domain,
            "z_mm": f"{z:.6g}",
            "full_order_N": force,
            "reduced_N": reduced.get(z, ""),
        }
        for z, force in sorted(zip(forces.position.tolist(), forces.full_order.tolist(), strict=True))
    ]
