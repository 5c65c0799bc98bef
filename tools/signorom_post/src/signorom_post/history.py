# SPDX-License-Identifier: BSD-3-Clause
"""A history of one point, answered time by time: `history = model.start(P=3.0)`, then `history.advance(0.5)`."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from ctypes import byref, c_void_p, sizeof
from types import TracebackType
from typing import Self

import numpy as np

from signorom_post.answer import Answer, Fields, NoAnswerError
from signorom_post.arrays import FloatArray, IntArray
from signorom_post.handles import Handles
from signorom_post.library import BAD_ARGUMENT, NO_ANSWER, CAnswer, doubles, text_of

#: a time, and the values of all tables there; None: those of the model's tables
Step = tuple[float, FloatArray | None]
#: makes the answer of a context at a state, with displacements of the given nodes (None: all); the last argument has all
#: steps of the history up to this state
AnswerMaker = Callable[
    [c_void_p, FloatArray, Sequence[int] | IntArray | None, CAnswer, tuple[Step, ...]], Answer
]

#: makes the fields of the last answer of a context at a state
FieldsMaker = Callable[[c_void_p, FloatArray, CAnswer], Fields]


class NoHistoryError(Exception):
    """The model has no history: its deck has no times."""


class History:
    """A history that Model.start began. One thread at a time may use it; `with` ends it, as the garbage collector does.

    The times need not be those of the deck's steps, and the tables may have other values, such as measured ones.
    """

    def __init__(
        self,
        handles: Handles,
        given: FloatArray,
        names: Sequence[str],
        answer_of: AnswerMaker,
        fields_of: FieldsMaker,
    ) -> None:
        """For Model.start: the values of the deck's parameters, and the names of all parameters of the model.

        ValueError if a table is not valid at the point.
        """
        self._library = handles.library
        self._n_parameters, self._tables = len(names), list(names[len(given) + 1 :])
        self._answer_of, self._fields_of = answer_of, fields_of
        self._steps: tuple[Step, ...] = ()
        self._last: tuple[FloatArray, CAnswer] | None = None
        self._stack = ExitStack()
        self._context: c_void_p | None = self._stack.enter_context(handles.context())
        if self._library.signorom_start(self._context, doubles(given)):
            message = text_of(self._library.signorom_message(self._context))
            self.close()
            raise ValueError(message)

    def advance(
        self, time: float, *, nodes: Sequence[int] | IntArray | None = None, **tables: float
    ) -> Answer:
        """Returns the answer at the next time [unit of time of the deck], which must be later than the one before.

        `tables`: values of all tables at this time by their names; without any, those of the deck's tables. nodes,
        NoAnswerError and ExtrapolationWarning are as for Model.query. Without values of tables, derivatives over the
        deck's parameters and the time contain what the deck's tables change. With friction, those over the deck's
        parameters contain what these change at all times before; the history is computed once more for them, and there
        are none where an earlier time has none. TypeError if only some tables are given
        or one is unknown; ValueError if a value is not finite, the time is not later, or the history was closed.
        """
        if self._context is None:
            raise ValueError("the history is closed")
        values = self._values_of(tables) if tables else None
        if not np.isfinite(time):
            raise ValueError(f"the time must be a finite number, not {time}")
        told = CAnswer(size=sizeof(CAnswer))
        self._last = None
        code = self._library.signorom_advance(
            self._context, float(time), None if values is None else doubles(values), byref(told)
        )
        if code:
            failure = {BAD_ARGUMENT: ValueError, NO_ANSWER: NoAnswerError}[code]
            raise failure(text_of(self._library.signorom_message(self._context)))
        self._steps = (*self._steps, (float(time), values))
        state = np.zeros(self._n_parameters)
        self._library.signorom_get_point(self._context, doubles(state))
        self._last = state, told
        return self._answer_of(self._context, state, nodes, told, self._steps)

    def fields(self) -> Fields:
        """Returns displacement, stresses, contact and friction on the whole mesh at the time of the last answer.

        NoAnswerError, FreeMotionWarning and InaccurateFieldsWarning are as for Model.fields; ValueError if there is no
        answer yet, the last time had none, or the history was closed.
        """
        if self._context is None:
            raise ValueError("the history is closed")
        if self._last is None:
            raise ValueError("the history has no answer whose fields could be given; call advance first")
        return self._fields_of(self._context, *self._last)

    def _values_of(self, tables: Mapping[str, float]) -> FloatArray:
        """Returns the values of all tables in the model's order."""
        if set(tables) != set(self._tables):
            raise TypeError(
                f"give a value for each table or for none: {', '.join(self._tables) or 'the model has no tables'}"
            )
        values = np.array([float(tables[name]) for name in self._tables])
        if not np.isfinite(values).all():
            raise ValueError("the value of a table must be a finite number")
        return values

    def close(self) -> None:
        """Ends the history. Later calls of `advance` raise ValueError."""
        self._context = None
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_stack"):
            self.close()
