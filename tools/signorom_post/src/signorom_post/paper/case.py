# SPDX-License-Identifier: BSD-3-Clause
"""Figure 8: the two bodies and their mesh."""

import numpy as np

from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, count, exactly
from signorom_post.paper.outcome import Outcome, Study
from signorom_post.paper.variants import STRONG, Variant
from signorom_post.plots.two_bodies import two_bodies


def figure_8(study: Study) -> Outcome:
    """Returns figure 8: a sketch with the load, and the mesh.

    Its table has the numbers of nodes and contact pairs, and lengths [mm]. The numbers are compared with the paper's.
    """
    (results,) = study.runs.results([Variant(12, None, has_fields=True)])
    fields = results.fields
    radius, height = fields.mesh.coordinates[:, 0], fields.mesh.coordinates[:, 1]
    is_fuel = radius < 0.5 * (
        radius[fields.contact.owners].mean() + radius[fields.contact.second.nodes].mean()
    )
    sizes = {
        "nodes": (fields.mesh.n_nodes, published.N_NODES),
        "nodes of the fuel": (int(is_fuel.sum()), published.N_FUEL_NODES),
        "nodes of the cladding": (int((~is_fuel).sum()), published.N_CLADDING_NODES),
        "contact pairs": (fields.contact.n_rows, published.N_PAIRS),
    }
    table = [{"quantity": name, "value": ours, "paper": paper} for name, (ours, paper) in sizes.items()]
    lengths = {
        "height [mm]": np.ptp(height),
        "radius of the fuel [mm]": radius[is_fuel].max(),
        "gap [mm]": radius[~is_fuel].min() - radius[is_fuel].max(),
        "thickness of the cladding [mm]": np.ptp(radius[~is_fuel]),
    }
    table += [{"quantity": name, "value": f"{value:.6g}", "paper": ""} for name, value in lengths.items()]
    comparisons = [
        Comparison("Fig. 8", name, paper, ours, count, exactly(paper))
        for name, (ours, paper) in sizes.items()
    ]
    return Outcome({"fig08": table}, {"fig08": two_bodies(fields, is_fuel, STRONG[1])}, comparisons)
