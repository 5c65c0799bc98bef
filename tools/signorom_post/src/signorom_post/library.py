# SPDX-License-Identifier: BSD-3-Clause
"""The C library `libsignorom_online` as ctypes sees it: where it is, its functions, structures and arrays.

Four places are tried in this order: the path in the variable SIGNOROM_LIBRARY, the folder `lib` of this package, the
loader's path, the build folder of the sources.
"""

import ctypes
import os
from contextlib import suppress
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_void_p
from pathlib import Path

from signorom_post.arrays import FloatArray, IntArray

# the interface that this module knows
SONAME = "libsignorom_online.so.0"
# values of signorom_answer.code and .method
OK, NO_ANSWER, BAD_ARGUMENT = 0, 1, 2
METHODS = ("none", "active_set", "block_pivoting", "lemke", "condensed")


class LibraryError(Exception):
    """The online library is missing or cannot be used."""


class CSizes(ctypes.Structure):
    """The structure signorom_sizes of signorom.h, which explains its members."""

    _fields_ = [
        (name, c_int)
        for name in (
            "n_parameters",
            "n_clusters",
            "n_contacts",
            "n_nodes",
            "n_dimensions",
            "n_dofs",
            "n_training_points",
            "has_full_order_multipliers",
            "has_full_order_displacement",
        )
    ]


class CAnswer(ctypes.Structure):
    """The structure signorom_answer of signorom.h, which explains its members."""

    _fields_ = [
        ("size", c_size_t),
        *(
            (name, c_int)
            for name in (
                "code",
                "method",
                "cluster",
                "n_modes",
                "n_domain_contacts",
                "n_active",
                "n_iterations",
                "is_inside_box",
            )
        ),
        ("distance", c_double),
        ("residual", c_double),
        ("n_solutions", c_int),
        ("bound", c_double),
        ("relative_bound", c_double),
        ("displacement_bound", c_double),
        ("relative_displacement_bound", c_double),
        ("n_free_motions", c_int),
        ("error_estimate", c_double),
    ]


class CArrays(ctypes.Structure):
    """The structure signorom_arrays of signorom.h, which explains its members."""

    _fields_ = [
        ("size", c_size_t),
        ("answers", c_void_p),
        ("multipliers", POINTER(c_double)),
        ("areas", POINTER(c_double)),
        ("forces", POINTER(c_double)),
        ("moments", POINTER(c_double)),
        ("n_nodes", c_int),
        ("nodes", POINTER(c_int)),
        ("displacement", POINTER(c_double)),
    ]


_DOUBLES = POINTER(c_double)
_INTS = POINTER(c_int)
_SIGNATURES = {
    "signorom_version": (c_char_p, []),
    "signorom_open": (c_int, [c_char_p, POINTER(c_void_p)]),
    "signorom_model_message": (c_char_p, [c_void_p]),
    "signorom_close": (None, [c_void_p]),
    "signorom_get_sizes": (c_int, [c_void_p, POINTER(CSizes)]),
    "signorom_text": (c_char_p, [c_void_p, c_int]),
    "signorom_get_parameter": (
        c_int,
        [c_void_p, c_int, POINTER(c_char_p), POINTER(c_char_p), _DOUBLES, _DOUBLES],
    ),
    "signorom_get_contact_nodes": (c_int, [c_void_p, c_int, _INTS, _INTS, _DOUBLES, _DOUBLES]),
    "signorom_get_contact_areas": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_force_directions": (c_int, [c_void_p, _INTS, _DOUBLES]),
    "signorom_get_contact_entries": (c_int, [c_void_p, _INTS, _INTS, _INTS]),
    "signorom_contact_entry_name": (c_char_p, [c_void_p, c_int]),
    "signorom_get_resultants": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES, _DOUBLES]),
    "signorom_get_nodes": (c_int, [c_void_p, _INTS, _DOUBLES]),
    "signorom_get_domain_contacts": (c_int, [c_void_p, c_int, _INTS, _INTS]),
    "signorom_get_displacement_sources": (c_int, [c_void_p, _INTS]),
    "signorom_get_next_cluster": (c_int, [c_void_p, _DOUBLES, _INTS]),
    "signorom_create_context": (c_int, [c_void_p, POINTER(c_void_p)]),
    "signorom_message": (c_char_p, [c_void_p]),
    "signorom_free_context": (None, [c_void_p]),
    "signorom_query": (c_int, [c_void_p, _DOUBLES, POINTER(CAnswer)]),
    "signorom_get_history": (c_int, [c_void_p, _INTS, _INTS, _DOUBLES]),
    "signorom_get_states": (c_int, [c_void_p, _DOUBLES, _DOUBLES]),
    "signorom_start": (c_int, [c_void_p, _DOUBLES]),
    "signorom_advance": (c_int, [c_void_p, c_double, _DOUBLES, POINTER(CAnswer)]),
    "signorom_get_memory_size": (c_int, [c_void_p, _INTS]),
    "signorom_get_memory": (c_int, [c_void_p, _DOUBLES]),
    "signorom_set_memory": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_point": (c_int, [c_void_p, _DOUBLES]),
    "signorom_query_arrays": (c_int, [c_void_p, c_int, _DOUBLES, POINTER(CArrays)]),
    "signorom_get_domain_multipliers": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_multipliers": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_coordinates": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_displacement": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_displacement_at": (c_int, [c_void_p, c_int, _INTS, _DOUBLES]),
    "signorom_get_field_sizes": (c_int, [c_void_p, _INTS, _INTS, _INTS, _INTS, _INTS]),
    "signorom_get_cells": (c_int, [c_void_p, _INTS, _INTS, _INTS]),
    "signorom_region_name": (c_char_p, [c_void_p, c_int]),
    "signorom_get_contact_facets": (c_int, [c_void_p, _INTS, _INTS, _INTS]),
    "signorom_get_stresses": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES, _DOUBLES]),
    "signorom_get_imposed_strains": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_friction_fields": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _INTS]),
    "signorom_get_plastic_strains": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES]),
    "signorom_get_creep_strains": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES]),
    "signorom_get_contact_fields": (c_int, [c_void_p, _DOUBLES, _DOUBLES, _DOUBLES, _INTS, _INTS]),
    "signorom_differentiate": (c_int, [c_void_p, c_int, _INTS, _INTS]),
    "signorom_get_multiplier_gradient": (c_int, [c_void_p, _DOUBLES]),
    "signorom_get_resultant_gradient": (c_int, [c_void_p, _DOUBLES, _DOUBLES]),
    "signorom_get_displacement_gradient_at": (c_int, [c_void_p, c_int, _INTS, _DOUBLES]),
    "signorom_get_displacement_gradient_errors": (c_int, [c_void_p, _DOUBLES]),
}


def find_library() -> str:
    """Returns the path of the online library, or its name if the loader finds it; LibraryError if it is not found.

    The places are, in this order, the path in SIGNOROM_LIBRARY (which is not checked), the folder `lib` of this
    package, the loader's path, and the build folders of the sources, of which the latest library is taken.
    """
    named = os.environ.get("SIGNOROM_LIBRARY")
    if named:
        return named
    installed = Path(__file__).parent / "lib" / SONAME
    if installed.is_file():
        return str(installed)
    with suppress(OSError):
        ctypes.CDLL(SONAME)
        return SONAME
    for root in Path(__file__).resolve().parents:
        built = sorted(root.glob("build/*/src/online/libsignorom_online.so"), key=lambda p: p.stat().st_mtime)
        if built:
            return str(built[-1])
    raise LibraryError(
        f"{SONAME} was not found: install the package without --editable, set SIGNOROM_LIBRARY to the library's path, "
        "or put it where the loader looks (ldconfig, LD_LIBRARY_PATH)"
    )


def load_library() -> ctypes.CDLL:
    """Returns the online library, with signatures as in signorom.h; LibraryError if it is missing or cannot be used."""
    path = find_library()
    try:
        library = ctypes.CDLL(path)
        for name, (result, arguments) in _SIGNATURES.items():
            function = getattr(library, name)
            function.restype = result
            function.argtypes = arguments
    except (OSError, AttributeError) as error:
        raise LibraryError(f"the library {path} cannot be used: {error}") from error
    return library


def loaded_library() -> Path:
    """Returns the path of the online library that this process has loaded. Requires: load_library was called."""
    # the loader may have found it by its name alone
    with Path("/proc/self/maps").open() as maps:
        return next(
            Path(line.rstrip("\n").split(maxsplit=5)[-1]) for line in maps if "libsignorom_online" in line
        )


def text_of(value: bytes | None) -> str:
    """Returns a text of the library; empty for None."""
    return (value or b"").decode("utf-8", "replace")


def known(bound: float) -> float | None:
    """Returns a bound or an estimate of an answer; None for SIGNOROM_NO_BOUND."""
    return None if bound < 0 else bound


def doubles(array: FloatArray) -> "ctypes._Pointer[c_double]":
    """Returns a pointer to the numbers of a contiguous array, which must live as long as the pointer."""
    return array.ctypes.data_as(_DOUBLES)


def ints(array: IntArray) -> "ctypes._Pointer[c_int]":
    """Returns a pointer to the numbers of a contiguous array of C ints, which must live as long as the pointer."""
    return array.ctypes.data_as(_INTS)
