# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of section 5.2 of Le Berre, Ramière, Fauque, Ryckelynck, Mathematics 10 (2022) 1495 (CC BY 4.0)."""

from dataclasses import dataclass

N_NODES, N_FUEL_NODES, N_CLADDING_NODES, N_PAIRS = 7070, 6161, 909, 101
N_SNAPSHOTS = 500
#: number of modes l at a POD tolerance of 1e-6
N_MODES = 36
#: kappa at which Algorithm 1 stops for the error maps
MAX_CONDITION_NUMBER = 10.0
#: POD modes that the second strategy of Figures 10, 11 and 13 adds
EXTRA_MODES = 9


@dataclass(frozen=True)
class Enrichment:
    """What the paper says of Algorithm 1 on one reduced domain."""

    #: size of the basis at which (11) holds for the first time, with hat functions only
    n_columns_solvable: int
    #: sizes of the basis at kappa_max = 10: with hat functions only, and with EXTRA_MODES more modes
    n_columns: tuple[int, int]
    #: dual error with all hats and no extra modes at (170 MPa, 3.2 mm), Figure 14
    dual_error: float


#: number of contact pairs in the reduced domain -> the paper's numbers
ENRICHMENT = {
    34: Enrichment(40, (55, 62), 0.025),
    60: Enrichment(61, (83, 91), 0.026),
}
#: Figure 10: dual error at the point (170 MPa, 3.2 mm) at kappa_max = 10, with hat functions only and 34 pairs
DUAL_ERROR_AT_10 = 0.063


@dataclass(frozen=True)
class Table1Row:
    """A row of Table 1; an error of 1 is 100 %."""

    extra_modes: int
    #: POD tolerance that gives the extra modes (epsilon_POD2); None in the row without extra modes
    tolerance: float | None
    #: kappa before the first hat
    condition_number: float
    #: final size of the basis
    n_columns: int
    #: primal and dual error at (170 MPa, 3.2 mm), and at (30 MPa, 5.25 mm)
    strong: tuple[float, float]
    weak: tuple[float, float]


TABLE_1 = (
    Table1Row(0, None, 1.5e6, 70, (0.010, 0.025), (0.029, 0.21)),
    Table1Row(3, 7.5e-7, 2.3e4, 73, (0.025, 0.018), (0.005, 0.26)),
    Table1Row(6, 5.0e-7, 4.5e3, 76, (0.005, 0.016), (0.016, 0.16)),
    Table1Row(9, 3.5e-7, 4.1e3, 79, (0.001, 0.013), (0.035, 0.056)),
    Table1Row(12, 2.7e-7, 3.4e3, 82, (0.014, 0.017), (0.025, 0.067)),
    Table1Row(15, 2.2e-7, 878.0, 85, (0.019, 0.017), (0.013, 0.058)),
    Table1Row(18, 1.7e-7, 386.0, 88, (0.011, 0.014), (0.002, 0.053)),
    Table1Row(21, 1.3e-7, 383.0, 91, (0.078, 0.018), (0.134, 0.093)),
    Table1Row(23, 1.1e-7, 330.0, 93, (0.008, 0.013), (0.16, 0.099)),
    Table1Row(26, 0.9e-7, 328.0, 96, (0.12, 0.013), (0.015, 0.095)),
)


@dataclass(frozen=True)
class LocalModel:
    """The paper's numbers of one of three clusters."""

    #: None if the paper does not give it
    n_snapshots: int | None
    n_modes: int
    n_contact_rows: int
    #: size of the basis at kappa_max = 10
    n_columns: int


#: Clusters of regular snapshots, in descending order of the height of the load. The order follows from the points of
#: Table 2: cluster 1 contains 5.25 mm, and cluster 2 contains 3.2 mm
CLUSTERS = (LocalModel(170, 31, 36, 54), LocalModel(194, 39, 40, 67), LocalModel(170, 36, 35, 57))


@dataclass(frozen=True)
class Table2Row:
    """A row of Table 2 (all hats); an error of 1 is 100 %."""

    #: kappa before the first hat
    condition_number: float
    n_modes: int
    n_columns: int
    primal: float
    dual: float


#: rows at the points (170 MPa, 3.2 mm) and (30 MPa, 5.25 mm)
TABLE_2 = (Table2Row(1.5e5, 39, 79, 0.0003, 0.020), Table2Row(2.2e4, 31, 67, 0.0002, 0.024))


#: Figures 19 to 22: number of snapshots, modes l at a POD tolerance of 1e-6, contact pairs at a dual tolerance of 1e-4
N_IRREGULAR, IRREGULAR_MODES, IRREGULAR_ROWS = 200, 33, 57
#: smaller POD tolerance, number of modes that it adds, and sizes of the basis at kappa_max = 10 without and with them
IRREGULAR_TOLERANCE, IRREGULAR_EXTRA, IRREGULAR_COLUMNS = 3.5e-7, 5, (60, 82)
#: clusters of irregular snapshots, in ascending order of the pairs in their domains: the paper's clusters 2, 0 and 1
IRREGULAR_CLUSTERS = (
    LocalModel(None, 23, 35, 48),
    LocalModel(None, 27, 36, 52),
    LocalModel(None, 35, 56, 77),
)


@dataclass(frozen=True)
class MapStatistics:
    """Statistics of the dual errors on the reduced domain at all points of a map; an error of 1 is 100 %."""

    median: float
    #: 95th percentile; None: no limit was set
    p95: float | None
    #: share of the points whose error is above 10 %
    above_10: float


#: (contact pairs in the reduced domain, extra modes) -> statistics of a map. The paper prints its maps as pictures, so
#: these are from an independent NumPy code: 40 x 40 points, kappa_max = 10, hats on the cladding
REFERENCE_MAPS = {
    (34, 0): MapStatistics(0.063, 0.39, 0.35),
    (34, 9): MapStatistics(0.044, 0.24, 0.24),
    (60, 0): MapStatistics(0.064, 0.40, 0.36),
    (60, 9): MapStatistics(0.042, 0.24, 0.26),
}
