# SPDX-License-Identifier: BSD-3-Clause
"""What an exploration asks of a model and what it may say: answers, fields, and what speaks against their numbers."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from signorom_post.answer import (
    Answer,
    Cells,
    Fields,
    FreeMotionWarning,
    InaccurateFieldsWarning,
    NoAnswerError,
    NotAcceptedWarning,
    Parameter,
)
from signorom_post.arrays import NO_UNITS, format_number, with_unit
from signorom_post.history import History
from signorom_post.online import Model
from signorom_post.points import range_of

#: what a remark may speak against
FORCES, DISPLACEMENTS, STRESSES = "forces", "displacements", "stresses"
ALL = frozenset({FORCES, DISPLACEMENTS, STRESSES})
#: what a warning of the model speaks against; of other warnings, all numbers
AGAINST = {
    FreeMotionWarning: frozenset({DISPLACEMENTS}),
    InaccurateFieldsWarning: frozenset({DISPLACEMENTS, STRESSES}),
}
#: a bound above this one says that the error may be of any size
ANY_SIZE = 1.0e308
Asked = TypeVar("Asked")


@dataclass(frozen=True)
class Remark:
    """A sentence about an answer, and which numbers the model does not vouch for because of it."""

    text: str
    against: frozenset[str] = ALL


@dataclass(frozen=True)
class Look:
    """What the model says at one point, in a history at one time. Without an answer, `refusal` says why."""

    #: values of the deck's parameters that the user chose, without time and tables
    point: dict[str, float]
    #: number of the time, from 0, and the time; None without a history
    step: int | None
    time: float | None
    answer: Answer | None
    #: None also where the model keeps no mesh or has no fields at this point
    fields: Fields | None
    remarks: tuple[Remark, ...]
    refusal: str = ""

    def speaks_against(self, what: str) -> bool:
        """Returns whether a remark speaks against forces, displacements or stresses; true without an answer."""
        return self.answer is None or any(what in remark.against for remark in self.remarks)


@dataclass(frozen=True)
class ErrorText:
    """What the model says about the error of one kind of results: a bound, an estimate, or nothing."""

    name: str
    text: str
    is_known: bool


class Exploration:
    """A model that is asked at one point after another. One thread at a time may use it."""

    def __init__(self, path: Path) -> None:
        """Opens the model file `path`; ModelError and LibraryError as for Model.

        What Model warns of, a model that was not accepted, is in `verdict` and a remark of every answer.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotAcceptedWarning)
            self.model = Model(path)
        self.path = path
        self.parameters: list[Parameter] = self.model.parameters[: self.model.n_given]
        self.cells, self.no_fields = _cells_of(self.model)
        self.verdict = self.model.verdict
        self._history: tuple[tuple[float, ...], History, int] | None = None

    @property
    def times(self) -> list[float]:
        """Times of the deck's steps; empty without a history."""
        return self.model.times.tolist()

    @property
    def is_accepted(self) -> bool | None:
        """Whether the validation accepted the model, its fields, too; None: the model was not validated."""
        return "NOT accepted" not in self.verdict if self.verdict else None

    def middle(self) -> dict[str, float]:
        """Returns the middle of the box, with six digits."""
        return {
            parameter.name: float(f"{0.5 * (parameter.minimum + parameter.maximum):.6g}")
            for parameter in self.parameters
        }

    def look(self, point: Mapping[str, float], step: int = -1) -> Look:
        """Asks the model at a point, a value for each of `parameters`, all finite.

        In a history, `step` is the number of the time, from 0; negative ones count from the end.
        """
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = self._look_at(dict(point), step % len(self.times) if self.times else None)
        remarks = list(found.remarks)
        for warning in said:
            remark = Remark(str(warning.message), AGAINST.get(warning.category, ALL))
            if remark not in remarks:
                remarks.append(remark)
        return Look(
            found.point, found.step, found.time, found.answer, found.fields, tuple(remarks), found.refusal
        )

    def _look_at(self, point: dict[str, float], step: int | None) -> Look:
        time = None if step is None else self.times[step]
        remarks = self._standing_remarks()
        try:
            if step is None:
                answer: Answer = self.model.query(nodes=(), **point)
                ask_fields: Callable[[], Fields] = lambda: self.model.fields(**point)  # noqa: E731
            else:
                history, answer = self._advance_to(point, step)
                ask_fields = history.fields
        except (NoAnswerError, ValueError) as error:
            return Look(point, step, time, None, None, remarks, str(error))
        if answer.n_solutions > 1:
            remarks += (
                Remark(
                    "the solver found two solutions: the contact forces are not unique",
                    frozenset({FORCES, STRESSES}),
                ),
            )
        fields, refusal = None, self.no_fields
        if self.cells is not None:
            fields, refusal = _or_reason(ask_fields)
        if fields is None and self.cells is not None:
            remarks += (Remark(f"there are no fields here: {refusal}", frozenset()),)
        return Look(point, step, time, answer, fields, remarks)

    def _standing_remarks(self) -> tuple[Remark, ...]:
        """Returns the remark on the verdict, if the model was not accepted. Fields alone may be what is not."""
        if self.is_accepted is not False:
            return ()
        forces_fail = self.verdict.startswith("NOT accepted")
        return (
            Remark(
                f"the validation of this model: {self.verdict}",
                ALL if forces_fail else frozenset({DISPLACEMENTS, STRESSES}),
            ),
        )

    def _advance_to(self, point: Mapping[str, float], step: int) -> tuple[History, Answer]:
        """Returns a history of this point whose last time is that of `step`, and its answer.

        A later time goes on with the history that is there, so that a film costs one step per picture.
        """
        key = tuple(point.values())
        if self._history is None or self._history[0] != key or self._history[2] >= step:
            self._end_history()
            self._history = (key, self.model.start(**point), -1)
        key, history, reached = self._history
        try:
            for i in range(reached + 1, step + 1):
                answer = history.advance(self.times[i], nodes=())
        except BaseException:
            self._end_history()
            raise
        self._history = (key, history, step)
        return history, answer

    def _end_history(self) -> None:
        if self._history is not None:
            self._history[1].close()
            self._history = None

    def errors(self, look: Look) -> list[ErrorText]:
        """Returns what the model says of the errors of contact forces and displacements, for people."""
        if look.answer is None:
            return [ErrorText("Error", "no answer", False)]
        answer = look.answer
        if answer.error_estimate is not None:
            forces = ErrorText("Forces", f"error about {percent(answer.error_estimate)} (an estimate)", True)
        elif self.model.remembers:
            forces = _bound_text("Forces", answer.relative_bound, "backward error of this step")
        else:
            forces = _bound_text("Forces", answer.relative_bound, "error at most")
        return [
            forces,
            _bound_text("Displacement", answer.relative_displacement_bound, "error at most"),
        ]

    def command(self, look: Look) -> str:
        """Returns the command of a shell that asks for the same; of a history, it prints all times."""
        values = ",".join(f"{name}={value!r}" for name, value in look.point.items())
        return f"signorom predict {_quoted(str(self.path))} --at {values}"

    def python(self, look: Look) -> str:
        """Returns a program in Python that asks for the same."""
        values = ", ".join(f"{name}={value!r}" for name, value in look.point.items())
        opening = f'from signorom_post import Model\n\nmodel = Model("{self.path}")\n'
        if look.step is None:
            return f"{opening}answer = model.query({values})\n"
        return (
            f"{opening}with model.start({values}) as history:\n"
            f"    for time in model.times[:{look.step + 1}]:\n"
            "        answer = history.advance(time)\n"
        )

    def close(self) -> None:
        """Closes the model."""
        self._end_history()
        self.model.close()


def value_of(text: str) -> float:
    """Returns the number in a text; ValueError, with a sentence for the user, if it is none or not finite."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"'{text}' is not a number" if text.strip() else "a number is missing") from None
    if not math.isfinite(value):
        raise ValueError(f"'{text}' is not a finite number")
    return value


def outside_text(parameter: Parameter, value: float) -> str:
    """Returns a sentence if a value lies outside of the trained range, else an empty text."""
    if parameter.minimum <= value <= parameter.maximum:
        return ""
    return f"outside of the trained range, {range_of(parameter)}: an extrapolation"


def percent(share: float) -> str:
    """Returns a relative error as a text: in percent down to a millionth of a percent, else as a power of ten."""
    return f"{format_number(100.0 * share)} %" if share >= 1e-8 or share == 0.0 else f"{share:.1e}"


def label_of(parameter: Parameter) -> str:
    """Returns the name of a parameter with its unit."""
    return with_unit(parameter.name, parameter.unit)


def unit_of(parameter: Parameter) -> str:
    """Returns the unit of a parameter, empty for a plain number."""
    return "" if parameter.unit in NO_UNITS else parameter.unit


def _cells_of(model: Model) -> tuple[Cells | None, str]:
    """Returns the mesh of the model, or None and why there is none."""
    return _or_reason(lambda: model.cells)


def _or_reason(ask: Callable[[], Asked]) -> tuple[Asked | None, str]:
    """Returns what `ask` returns and an empty text, or None and why the model cannot give it."""
    try:
        return ask(), ""
    except NoAnswerError as error:
        return None, str(error)


def _bound_text(name: str, bound: float | None, what: str) -> ErrorText:
    if bound is None:
        return ErrorText(name, "error not known", False)
    if bound > ANY_SIZE:
        return ErrorText(name, "error may be of any size", False)
    return ErrorText(name, f"{what} {percent(bound)}", True)


def _quoted(text: str) -> str:
    return text if all(letter.isalnum() or letter in "/._-" for letter in text) else f"'{text}'"


def sentence_of(remarks: Sequence[Remark]) -> str:
    """Returns the remarks as one text, a sentence each."""
    return " ".join(f"{remark.text[:1].upper()}{remark.text[1:]}." for remark in remarks)
