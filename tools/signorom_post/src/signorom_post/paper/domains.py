# SPDX-License-Identifier: BSD-3-Clause
"""Figures 9 and 12: the reduced integration domains."""

from collections.abc import Sequence

from signorom_post.paper import published
from signorom_post.paper.comparison import Comparison, about, count, exactly
from signorom_post.paper.outcome import Outcome, Row, Study, n_contact_rows
from signorom_post.paper.variants import Variant
from signorom_post.plots.reduced_domain import reduced_domain
from signorom_post.plots.singular_values import kept_modes
from signorom_post.readers.fields import FieldFile
from signorom_post.readers.model import Cluster
from signorom_post.results import Results

#: allowed difference in the number of contact pairs of a domain. This number depends on ties in DEIM and on the exact
#: dimensions of the mesh
MARGIN = 6


def figure_9(study: Study) -> Outcome:
    """Returns figure 9: two reduced domains, with their tables and comparisons.

    The first one comes from DEIM of displacements only, the second one (34 pairs in the paper) also from contact
    forces.
    """
    return _domains(study, {"fig09a": 12, "fig09b": 34})


def figure_12(study: Study) -> Outcome:
    """Returns figure 12: the reduced domain that has 60 contact pairs in the paper.

    It comes from DEIM of displacements and of contact forces, with a smaller POD tolerance of the forces than figure 9.
    """
    return _domains(study, {"fig12": 60})


def _domains(study: Study, domains: dict[str, int]) -> Outcome:
    outcome = Outcome({}, {})
    # the domain does not depend on the hats: models with all hats are taken, because Figure 14 runs them anyway
    ours, cut = study.both_loads(
        [Variant(domain, None if domain == 12 else 1.0, has_fields=True) for domain in domains.values()]
    )
    for (name, domain), results, results_cut in zip(domains.items(), ours, cut, strict=True):
        where = f"Fig. {name[3:].lstrip('0')}"
        cluster = results.model.clusters[0]
        outcome.tables[name] = domain_table(results.fields, cluster)
        outcome.figures[name] = reduced_domain(results.fields, cluster, ("r", "z"))
        n_modes, n_modes_cut = (
            kept_modes(r.model.clusters[0], r.model.pod_tolerance) for r in (results, results_cut)
        )
        n, n_cut = n_contact_rows(results), n_contact_rows(results_cut)
        if domain == min(domains.values()):
            outcome.comparisons.append(
                Comparison(
                    where,
                    "modes l",
                    published.N_MODES,
                    n_modes,
                    count,
                    exactly(published.N_MODES),
                    cut=n_modes_cut,
                )
            )
        outcome.comparisons.append(
            Comparison(
                where,
                "contact pairs in the RID",
                domain,
                n,
                count,
                about(domain, MARGIN),
                is_robust=False,
                cut=n_cut,
            )
        )
    return outcome


def domain_table(fields: FieldFile, cluster: Cluster) -> list[Row]:
    """Returns rows with kind, number and place of each seed node, facing node, contact pair and cell of the domain.

    Numbers count from 1, in the order of `fields`; a contact pair has the number of its row. Places are r and z [mm]:
    of a contact pair those of its owner, of a cell the mean of its nodes.
    """
    places = fields.mesh.coordinates
    centers = [places[cell].mean(axis=0) for cell in fields.mesh.cells]
    kinds = {
        "seed node": (cluster.seed_nodes, places),
        "facing node": (cluster.facing_nodes, places),
        "contact pair": (cluster.contact_rows, places[fields.contact.owners]),
        "cell": (cluster.cells, centers),
    }
    return [
        {"what": kind, "number": int(i) + 1, "r_mm": f"{where[i][0]:.6g}", "z_mm": f"{where[i][1]:.6g}"}
        for kind, (items, where) in kinds.items()
        for i in items
    ]


def domains_of_clusters(
    where: str,
    results: Results,
    clusters: Sequence[Cluster],
    papers: Sequence[published.LocalModel],
    remark: str = "",
) -> Outcome:
    """Returns a picture and a table of the reduced integration domain of each of `clusters`, which are at most three.

    Their numbers of POD modes and of contact pairs are compared with those of the paper; `remark` goes into each
    comparison.

    `where` is the figure of the paper, such as `Fig. 17`: names of tables and pictures are then `fig17a`, `fig17b`, ...
    `papers` are the numbers in the paper, as many as `clusters` and in the same order.
    """
    outcome = Outcome({}, {})
    for i, (cluster, paper) in enumerate(zip(clusters, papers, strict=True), start=1):
        name = f"fig{where.removeprefix('Fig. ')}{'abc'[i - 1]}"
        outcome.tables[name] = domain_table(results.fields, cluster)
        outcome.figures[name] = reduced_domain(results.fields, cluster, ("r", "z"))
        sizes = results.report["reduction"]["clusters"][cluster.name]
        for key, text in (("n_modes", "modes l"), ("n_contact_rows", "contact pairs")):
            told = f"{text} of cluster {i}"
            ours = Comparison(
                where, told, getattr(paper, key), sizes[key], count, is_robust=False, remark=remark
            )
            outcome.comparisons.append(ours)
    return outcome
