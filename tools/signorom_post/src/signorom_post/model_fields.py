# SPDX-License-Identifier: BSD-3-Clause
"""Gets the mesh and the fields of a model from the online library."""

import ctypes
from ctypes import byref, c_int, c_void_p

import numpy as np

from signorom_post.answer import Cells, Fields, NoAnswerError
from signorom_post.arrays import FloatArray, IntArray
from signorom_post.library import CAnswer, CSizes, doubles, ints, known, text_of

NO_CELLS = "the model keeps no mesh for fields: train it with reduction.fields: true in the deck"
STRESS_UNIT, AREA_UNIT = 6, 7


def _sizes(library: ctypes.CDLL, model: c_void_p) -> tuple[int, ...]:
    """Returns the numbers of cells, of nodes of all cells, of regions, of facets, and of nodes of all facets."""
    numbers = [c_int() for _ in range(5)]
    library.signorom_get_field_sizes(model, *(byref(number) for number in numbers))
    return tuple(number.value for number in numbers)


def cells_of(library: ctypes.CDLL, model: c_void_p) -> Cells:
    """Returns the mesh of the model; NoAnswerError if the model keeps no mesh for fields."""
    n_cells, n_cell_nodes, n_regions, n_facets, n_facet_nodes = _sizes(library, model)
    starts, nodes, regions = (np.zeros(n, dtype=np.intc) for n in (n_cells + 1, n_cell_nodes, n_cells))
    facets = [np.zeros(n, dtype=np.intc) for n in (n_facets + 1, n_facet_nodes, n_facets)]
    if library.signorom_get_cells(model, ints(starts), ints(nodes), ints(regions)):
        raise NoAnswerError(NO_CELLS)
    library.signorom_get_contact_facets(model, *(ints(array) for array in facets))
    return Cells(
        *(array.astype(np.int64) for array in (starts, nodes, regions)),
        [text_of(library.signorom_region_name(model, i)) for i in range(n_regions)],
        *(array.astype(np.int64) for array in facets),
    )


def fields_of(
    library: ctypes.CDLL,
    model: c_void_p,
    context: c_void_p,
    sizes: CSizes,
    point: dict[str, float],
    contact_area: FloatArray,
    told: CAnswer,
) -> Fields:
    """Returns the fields of the last answer in the context.

    NoAnswerError if the model gives no fields, or if an elastic constant, an imposed strain or Hooke's matrix is not
    finite at the point. `sizes` are those of the model. `point` (name -> value) and `contact_area` (Resultants.areas)
    are the parameters and the contact areas of this answer, `told` is what the library said of it.
    """
    n_cells, n_nodes, n_dimensions = _sizes(library, model)[0], sizes.n_nodes, sizes.n_dimensions
    displacement, contact_force = np.zeros((n_nodes, n_dimensions)), np.zeros((n_nodes, n_dimensions))
    stress, von_mises, imposed_strain = np.zeros((n_cells, 6)), np.zeros(n_cells), np.zeros((n_cells, 6))
    stress_smoothed, von_mises_smoothed = np.zeros((n_nodes, 6)), np.zeros(n_nodes)
    contact_pressure, gap = np.zeros(n_nodes), np.zeros(n_nodes)
    status, contact_status = np.zeros(n_nodes, dtype=np.intc), np.zeros(n_cells, dtype=np.intc)
    if (
        library.signorom_get_stresses(
            context,
            doubles(stress),
            doubles(von_mises),
            doubles(stress_smoothed),
            doubles(von_mises_smoothed),
        )
        or library.signorom_get_imposed_strains(context, doubles(imposed_strain))
        or library.signorom_get_contact_fields(
            context,
            doubles(contact_force),
            doubles(contact_pressure),
            doubles(gap),
            ints(status),
            ints(contact_status),
        )
        or library.signorom_get_displacement(context, doubles(displacement))
    ):
        raise NoAnswerError(text_of(library.signorom_message(context)))
    friction = _friction_of(library, context, n_nodes, n_dimensions)
    units = _units(library, model)
    if friction is not None:
        units |= {
            "tangential_traction": units["stress"],
            "slip": units["displacement"],
            "friction_status": "-",
        }
    strains: dict[str, FloatArray] = {}
    for kind in ("plastic", "creep"):
        strains |= _strains_of(library, context, kind, n_cells, n_nodes)
    units |= dict.fromkeys(strains, "-")
    return Fields(
        point=point,
        displacement=displacement,
        stress=stress,
        von_mises=von_mises,
        imposed_strain=imposed_strain,
        stress_smoothed=stress_smoothed,
        von_mises_smoothed=von_mises_smoothed,
        contact_force=contact_force,
        contact_pressure=contact_pressure,
        gap=gap,
        status=status.astype(np.int64),
        contact_status=contact_status.astype(np.int64),
        contact_area=contact_area,
        units=units,
        displacement_bound=known(told.displacement_bound),
        relative_displacement_bound=known(told.relative_displacement_bound),
        tangential_traction=None if friction is None else friction[0],
        slip=None if friction is None else friction[1],
        friction_status=None if friction is None else friction[2],
        **strains,
    )


def _friction_of(
    library: ctypes.CDLL, context: c_void_p, n_nodes: int, n_dimensions: int
) -> tuple[FloatArray, FloatArray, IntArray] | None:
    """Returns traction, slip and status of friction at the nodes; None without friction."""
    traction, slip = np.zeros((n_nodes, n_dimensions)), np.zeros((n_nodes, n_dimensions))
    status = np.zeros(n_nodes, dtype=np.intc)
    if library.signorom_get_friction_fields(context, doubles(traction), doubles(slip), ints(status)):
        return None
    return traction, slip, status.astype(np.int64)


def _strains_of(
    library: ctypes.CDLL, context: c_void_p, kind: str, n_cells: int, n_nodes: int
) -> dict[str, FloatArray]:
    """Returns the fields of the strains of a kind, `plastic` or `creep`, by their names; empty where there are none."""
    strain, tensor, smoothed = np.zeros(n_cells), np.zeros((n_cells, 6)), np.zeros(n_nodes)
    get = getattr(library, f"signorom_get_{kind}_strains")
    if get(context, doubles(strain), doubles(tensor), doubles(smoothed)):
        return {}
    return {
        f"{kind}_strain": strain,
        f"{kind}_strain_tensor": tensor,
        f"{kind}_strain_smoothed": smoothed,
    }


def _units(library: ctypes.CDLL, model: c_void_p) -> dict[str, str]:
    length, force, stress, area = (
        text_of(library.signorom_text(model, kind)) for kind in (1, 2, STRESS_UNIT, AREA_UNIT)
    )
    return {
        "displacement": length,
        "stress": stress,
        "von_mises": stress,
        "imposed_strain": "-",
        "stress_smoothed": stress,
        "von_mises_smoothed": stress,
        "contact_force": force,
        "contact_pressure": stress,
        "gap": length,
        "status": "-",
        "contact_status": "-",
        "contact_area": area,
    }
