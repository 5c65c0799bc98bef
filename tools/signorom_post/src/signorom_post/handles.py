# SPDX-License-Identifier: BSD-3-Clause
"""Handles of the library for an open model: the model and its contexts, which several threads use."""

import os
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref, c_void_p

from signorom_post.answer import ModelError, NotAcceptedWarning
from signorom_post.library import load_library, text_of

# Only one thread at a time may make or free handles of the library. The lock is reentrant: while a thread holds it, the
# garbage collector may free another model in the same thread.
_making = threading.RLock()
#: SIGNOROM_TEXT_VERDICT of signorom.h
_VERDICT = 9


class Handles:
    """The library's handles of one open model. A context serves one thread at a time, so each caller borrows one."""

    def __init__(self, path: str) -> None:
        """Opens the model file `path`; ModelError if the library cannot read it or if the model cannot answer.

        LibraryError if the library is missing or cannot be used. NotAcceptedWarning, with the sentence of the verdict
        and the line of the caller's caller, if the validation did not accept the model.
        """
        self._lock = threading.Lock()
        self._model = c_void_p()
        self._idle: list[c_void_p] = []
        self._n_users = 0
        self._is_closed = False
        self.library = load_library()
        self.path = path
        try:
            with _making:
                if self.library.signorom_open(os.fsencode(path), byref(self._model)):
                    raise self._failure(self.library.signorom_model_message(self._model))
            with self.context():
                pass  # making a context fails if the model cannot answer
            verdict = text_of(self.library.signorom_text(self._model, _VERDICT))
            if verdict.startswith("NOT accepted"):
                warnings.warn(f"the validation of this model: {verdict}", NotAcceptedWarning, stacklevel=3)
        except BaseException:
            self.close()
            raise

    def _failure(self, message: bytes | None) -> ModelError:
        sentence = text_of(message) or "no memory for the model"
        return ModelError(self.path, sentence.removeprefix(f"{self.path}: error: "))

    @contextmanager
    def model(self) -> Iterator[c_void_p]:
        """Gives the model's handle to a `with` block. It stays valid there, even if another thread closes the model.

        ValueError if the model is closed.
        """
        with self._lock:
            if self._is_closed:
                raise ValueError("the model is closed")
            self._n_users += 1
        try:
            yield self._model
        finally:
            with self._lock:
                self._n_users -= 1
            self._free_if_unused()

    @contextmanager
    def context(self) -> Iterator[c_void_p]:
        """Gives a context to a `with` block, in which no other caller has it. It is one that is free, or a new one.

        ValueError if the model is closed, ModelError if a new context cannot be made.
        """
        with self.model() as model:
            context = self._take() or self._new_context(model)
            try:
                yield context
            finally:
                with self._lock:
                    self._idle.append(context)

    def _take(self) -> c_void_p | None:
        with self._lock:
            return self._idle.pop() if self._idle else None

    def _new_context(self, model: c_void_p) -> c_void_p:
        context = c_void_p()
        with _making:
            if self.library.signorom_create_context(model, byref(context)):
                failure = self._failure(self.library.signorom_message(context))
                self.library.signorom_free_context(context)
                raise failure
        return context

    def close(self) -> None:
        """Closes the model for new callers. It is freed at once, or when the last caller that still uses it ends."""
        with self._lock:
            self._is_closed = True
        self._free_if_unused()

    def _free_if_unused(self) -> None:
        with self._lock:
            if not self._is_closed or self._n_users > 0:
                return
            model, self._model = self._model, c_void_p()
            contexts, self._idle = self._idle, []
        with _making:
            for context in contexts:
                self.library.signorom_free_context(context)
            if model:
                self.library.signorom_close(model)
