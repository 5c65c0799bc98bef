# SPDX-License-Identifier: BSD-3-Clause
"""The decks of the reduced models of case b that the paper shows."""

import copy
from dataclasses import dataclass
from typing import Any

#: the paper's number of contact pairs in a reduced domain -> tolerance (energy tail) of the POD of the contact forces,
#: whose DEIM nodes are added to the domain; None: no such nodes
DOMAINS: dict[int, float | None] = {12: None, 34: 4.0e-4, 60: 1.0e-4}
#: body whose nodes have the hat functions -> side of the contact pairs in the deck
SIDES = {"cladding": "second", "fuel": "first"}
#: points of strong and weak contact: pressure [MPa] and height [mm]
STRONG, WEAK = (170.0, 3.2), (30.0, 5.25)
POINTS = (STRONG, WEAK)
POD_TOLERANCE = 1.0e-6
#: POD tolerances of the displacements and of the contact forces, for models with clusters
LOCAL_TOLERANCES: tuple[float, float | None] = (1.0e-8, 1.0e-6)
ZONE = "cladding_outside"
#: [MB] largest size of the full-order operator on the contact forces; it answers where the reduced problem has no
#: solution
FULL_ORDER_SIZE = 1.0
#: training points: on the grid of the deck, or scattered
GRID, IRREGULAR = "grid", "irregular"
#: section `training` of the deck that chooses scattered points, as in input/pellet_cladding_greedy.yaml
IRREGULAR_POINTS: dict[str, Any] = {
    "greedy": {"candidates": {"sobol": 2000}, "indicator": "projection", "initial": 10, "max_points": 200}
}
#: number of trees and seed of the program's random forest
FOREST_TREES, FOREST_SEED = 100, 1
#: edges that carry the pressure: only those that lie below the height as a whole, as in the paper, or also the lower
#: part of the edge that the height cuts
LOADS = ("whole_edges", "cut")


@dataclass(frozen=True)
class Variant:
    """One reduced model, and the points where it is compared with the full order."""

    #: key of DOMAINS; None with clusters, because each cluster has its own domain
    domain: int | None
    #: Algorithm 1 ends at this kappa (kappa_max); None: no hat functions
    max_condition_number: float | None = 10.0
    #: Algorithm 1 also ends after this number of hats; None: no limit
    max_hats: int | None = None
    #: number of POD modes beyond those that choose the domain
    extra_modes: int = 0
    #: POD tolerance that gives the extra modes in place of their number; None: `extra_modes` counts
    extended_tolerance: float | None = None
    #: key of SIDES: the body with the hat functions
    side: str = "cladding"
    #: one of LOADS
    load: str = LOADS[0]
    #: the test points are a grid with this number of points per parameter; None: the two POINTS
    n_map: int | None = None
    #: number of local models, by the paper's method for these snapshots; None: one model
    n_clusters: int | None = None
    #: GRID or IRREGULAR
    training: str = GRID
    #: whether the model and the fields are kept, not only the tables
    has_fields: bool = False

    @property
    def name(self) -> str:
        """Path of this variant's folder below the folder of all runs, such as `cut/rid34_plus0_cladding_kappa10`."""
        of_what = f"rid{self.domain}" if self.n_clusters is None else f"clusters{self.n_clusters}"
        parts = [of_what, f"plus{self.extra_modes}"]
        if self.training != GRID:
            parts.insert(0, self.training)
        if self.extended_tolerance is not None:
            parts.append(f"tail{self.extended_tolerance:g}")
        if self.max_condition_number is not None:
            parts += [self.side, f"kappa{self.max_condition_number:g}"]
        if self.max_hats is not None:
            parts.append(f"hats{self.max_hats}")
        if self.n_map is not None:
            parts.append(f"map{self.n_map}")
        if self.has_fields:
            parts.append("fields")
        return f"{self.load}/{'_'.join(parts)}"

    def deck(self, base: dict[str, Any], points_file: str, irregular_file: str) -> dict[str, Any]:
        """Returns the deck of this variant. It puts the results into the folder of the deck.

        `base` is the deck of case b. `points_file`, the test points, counts only if `n_map` is None; `irregular_file`,
        the scattered training points, counts only if `training` is IRREGULAR. Both are paths from the deck.
        """
        deck = with_load(base, self.load)
        if self.training == IRREGULAR:
            deck["training"] = {"file": irregular_file}
        n = self.n_map
        deck["test"] = {"grid": {"P1": n, "h1": n}} if n else {"file": points_file}
        if self.n_clusters is not None:
            method = "regular" if self.training == GRID else "irregular"
            deck["clusters"] = {"number": self.n_clusters, "method": method}
        deck["reduction"] = self._reduction()
        deck["output"]["fields"] = ["displacement", "contact"]
        deck["output"]["points"] = [dict(zip(("P1", "h1"), point, strict=True)) for point in POINTS]
        return deck

    def _reduction(self) -> dict[str, Any]:
        tolerance, dual_tolerance = LOCAL_TOLERANCES
        if self.domain is not None:
            tolerance, dual_tolerance = POD_TOLERANCE, DOMAINS[self.domain]
        reduction: dict[str, Any] = {
            "method": "hhr",
            "pod_tolerance": tolerance,
            "extra_modes": self.extra_modes,
            "zones_of_interest": [ZONE],
            "max_full_order_size": FULL_ORDER_SIZE,
        }
        if self.extended_tolerance is not None:
            del reduction["extra_modes"]
            reduction["extended_pod_tolerance"] = self.extended_tolerance
        if dual_tolerance is not None:
            reduction["dual_pod_tolerance"] = dual_tolerance
        if self.max_condition_number is not None:
            greedy = {"max_condition_number": self.max_condition_number, "side": SIDES[self.side]}
            reduction["enrichment"] = {"type": "greedy", **greedy}
            if self.max_hats is not None:
                reduction["enrichment"]["max_hats"] = self.max_hats
        return reduction


def with_training(deck: dict[str, Any], training: str) -> dict[str, Any]:
    """Returns a copy of a deck. If `training` is IRREGULAR, IRREGULAR_POINTS replace its training points."""
    deck = copy.deepcopy(deck)
    if training == IRREGULAR:
        deck["training"] = IRREGULAR_POINTS
    return deck


def with_load(base: dict[str, Any], load: str) -> dict[str, Any]:
    """Returns a copy of the deck of case b with this load, one of LOADS.

    The copy's section `output` has only one key, which puts the results into the folder of the deck.
    """
    deck = copy.deepcopy(base)
    deck["loads"][0]["load"] = load
    deck["output"] = {"directory": "."}
    return deck
