# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post fmu`: writes a model as an FMU (FMI 3.0) for simulators of systems."""

import argparse
import warnings
from pathlib import Path

from signorom_post.answer import ModelError, NoAnswerError, NotAcceptedWarning
from signorom_post.errors import InputError, writing
from signorom_post.fmu import identifier, write_fmu
from signorom_post.library import LibraryError
from signorom_post.online import Model


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `signorom-post fmu` to its parser."""
    parser.add_argument("model", metavar="MODEL", type=Path, help="for instance results/part/model.h5")
    parser.add_argument(
        "--output",
        metavar="FILE",
        type=Path,
        help="default: the deck's title, with _ for blanks and other signs, and .fmu, beside MODEL",
    )
    parser.add_argument(
        "--nodes",
        metavar="TAGS",
        help="numbers of nodes in the mesh file whose displacements are outputs, for instance 12,57; default: none",
    )


def run(options: argparse.Namespace) -> int:
    """Writes the FMU and prints its path. Returns 0.

    Warns if the validation did not accept the model, and if the FMU has no derivatives.

    InputError if the model or the online library cannot be used, if --nodes is not valid, if a library that the FMU
    needs is missing, if the model has no answer in the middle of its box, where the FMU starts, or if the FMU cannot be
    written.
    """
    tags = tags_of(options.nodes)
    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", NotAcceptedWarning)
            model = Model(options.model)
    except ModelError as error:
        raise InputError(options.model, str(error).removeprefix(f"{options.model}: error: ")) from error
    except LibraryError as error:
        raise InputError("signorom-post fmu", str(error)) from error
    for warning in said:
        options.log.note(f"warning: {warning.message}")
    with model:
        output = options.output or options.model.with_name(f"{identifier(model.title)}.fmu")
        try:
            with writing("the FMU", output):
                refusal = write_fmu(model, options.model, output, tags)
        except NoAnswerError as error:
            raise InputError(
                options.model,
                f"the model has no answer in the middle of its box, where the FMU starts: {error}",
            ) from error
    if refusal:
        options.log.note(
            f"{output}: warning: the FMU has no derivatives, because the model has none in the middle of its box, where "
            f"the FMU starts: {refusal}"
        )
    options.log.result(output)
    return 0


def tags_of(text: str | None) -> list[int]:
    """Returns the numbers in a text such as `12,57`; an empty list for None. Empty words between commas are left out.

    InputError if a word is no whole number.
    """
    try:
        return [int(word) for word in (text or "").split(",") if word.strip()]
    except ValueError as error:
        raise InputError(
            "signorom-post fmu",
            f"--nodes is '{text}'; it needs whole numbers with commas, for instance 12,57",
        ) from error
