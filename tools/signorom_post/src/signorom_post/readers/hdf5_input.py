# SPDX-License-Identifier: BSD-3-Clause
"""Reads an HDF5 file. Each error is an InputError: one sentence with the name of the file."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np

from signorom_post.arrays import FloatArray, IntArray, Quantity
from signorom_post.errors import InputError, MissingFileError


def require_file(path: Path) -> None:
    """Raises InputError if the file is a folder or empty, MissingFileError if it is missing or not finished."""
    if path.is_dir():
        raise InputError(path, "this is a folder, not a file")
    if not path.exists():
        partial = path.with_name(path.name + ".partial")
        if partial.exists():
            raise MissingFileError(path, f"there is only '{partial.name}' of a run that has not finished")
        raise MissingFileError(path, "there is no such file")
    if path.stat().st_size == 0:
        raise InputError(path, "the file is empty")


class Hdf5Input:
    """The datasets and attributes of an HDF5 file. Each error is an InputError with the name of the file.

    Use it in a `with` block, which closes the file.
    """

    def __init__(self, path: Path) -> None:
        """Opens a file; InputError if it is missing or cannot be read."""
        self.path = path
        require_file(path)
        try:
            self._file = h5py.File(path, "r")
        except PermissionError as error:
            raise InputError(path, "the file may not be read by this user") from error
        except OSError as error:
            if "truncated" in str(error):
                raise InputError(path, "the file is truncated: its end is missing") from error
            if "unable to lock" in str(error):  # "superblock" of a damaged file has the word, too
                raise InputError(
                    path,
                    "the file cannot be locked: another program has it open for writing, or the file system has no "
                    "locks (then set HDF5_USE_FILE_LOCKING=FALSE)",
                ) from error
            raise InputError(path, "this is not an HDF5 file, or it is damaged") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def fail(self, sentence: str) -> InputError:
        """Returns an error about this file, which the caller raises."""
        return InputError(self.path, sentence)

    def check_format(self, name: str, version: int, oldest: int | None = None) -> None:
        """Raises InputError unless the attributes of the file say that its format is `name`, in version `version`.

        Versions from `oldest` on are read, too.
        """
        found = self.attribute("/", "format")
        if found is None:
            raise self.fail(f"the file is not a '{name}' file: it has no attribute 'format'")
        if found != name:
            raise self.fail(f"the file is a '{found}' file; a '{name}' file is needed")
        found_version = self.attribute("/", "format_version")
        first = version if oldest is None else oldest
        if not isinstance(found_version, int) or not first <= found_version <= version:
            sentence = f"the file has format version {found_version}; this tool reads version {version}"
            is_older = isinstance(found_version, int) and found_version < first
            raise self.fail(sentence + ("; run the command that wrote it again" if is_older else ""))

    @contextmanager
    def _guarded(self, what: str) -> Iterator[None]:
        """Turns every exception of h5py into one InputError, because damaged files cause many types of them."""
        try:
            yield
        except InputError:
            raise
        except Exception as error:
            raise self.fail(f"{what} cannot be read: the file is damaged or truncated") from error

    def has(self, name: str) -> bool:
        """Returns whether there is a dataset or group of this name (a path from the root of the file)."""
        with self._guarded(f"'{name}'"):
            return name in self._file

    def names(self, group: str) -> list[str]:
        """Returns the sorted names of the datasets and groups in a group; empty if the group is missing."""
        with self._guarded(f"group '{group}'"):
            node = self._file.get(group)
            return sorted(node) if isinstance(node, h5py.Group) else []

    def is_dataset(self, name: str) -> bool:
        """Returns whether there is a dataset of this name."""
        with self._guarded(f"'{name}'"):
            return name in self._file and isinstance(self._file[name], h5py.Dataset)

    def _raw(self, name: str) -> Any:
        if not self.has(name):
            raise self.fail(f"dataset '{name}' is missing")
        with self._guarded(f"dataset '{name}'"):
            node = self._file[name]
            if not isinstance(node, h5py.Dataset):
                raise self.fail(f"'{name}' is a group; a dataset is needed")
            return node[()]

    def reals(self, name: str, n_axes: int) -> FloatArray:
        """Returns a dataset of real or integer numbers as real numbers.

        InputError if it is missing, is a group, has no numbers, or does not have `n_axes` dimensions.
        """
        values = np.asarray(self._raw(name))
        if values.dtype.kind not in "fiub":
            raise self.fail(f"dataset '{name}' is text; numbers are needed")
        if values.ndim != n_axes:
            raise self.fail(f"dataset '{name}' has {values.ndim} axes; {n_axes} are needed")
        return values.astype(np.float64)

    def integers(self, name: str, n_axes: int = 1) -> IntArray:
        """Returns a dataset of whole numbers.

        InputError if it is missing, has other values, or does not have `n_axes` dimensions.
        """
        values = self.reals(name, n_axes)
        if not np.all(np.isfinite(values)) or np.any(values != np.round(values)):
            raise self.fail(f"dataset '{name}' has values that are not integers")
        return values.astype(np.int64)

    def indices(self, name: str, n_items: int, lowest: int = 1) -> IntArray:
        """Returns a list of numbers of items, which the file counts from 1, counted from 0; shape (n).

        InputError if the dataset is missing, is no list of whole numbers, or has numbers outside of `lowest` to
        `n_items`. With `lowest` = 0, the file's 0 means no item, and is returned as -1.
        """
        values = self.integers(name)
        if values.size and (values.min() < lowest or values.max() > n_items):
            outside = values[(values < lowest) | (values > n_items)][0]
            raise self.fail(f"dataset '{name}' has the number {outside}; allowed are {lowest} to {n_items}")
        return values - 1

    def quantity(self, name: str) -> Quantity:
        """Returns a dataset of numbers of any shape with its unit and description; InputError if missing or text."""
        values = np.asarray(self._raw(name))
        if values.dtype.kind not in "fiub":
            raise self.fail(f"dataset '{name}' is text; numbers are needed")
        return Quantity(
            values.astype(np.float64), self.unit(name), str(self.attribute(name, "description") or "")
        )

    def text(self, name: str) -> str:
        """Returns the first text of a dataset; empty if it has none. InputError if the dataset is missing."""
        texts = self.texts(name)
        return texts[0] if texts else ""

    def texts(self, name: str) -> list[str]:
        """Returns the texts of a dataset without blanks behind them, numbers as text; InputError if it is missing."""
        values = np.atleast_1d(np.asarray(self._raw(name), dtype=object)).ravel()
        return [_to_text(value) for value in values]

    def attribute(self, name: str, attribute: str) -> Any:
        """Returns an attribute of a dataset or group as text, number, array or list of texts; None if it has none.

        An array of one number is returned as a number. InputError if there is no dataset or group `name`.
        """
        with self._guarded(f"attribute '{attribute}' of '{name}'"):
            value = self._file[name].attrs.get(attribute)
        if isinstance(value, bytes | str):
            return _to_text(value)
        if isinstance(value, np.ndarray) and value.dtype.kind in "SOU":
            texts = [_to_text(item) for item in value.ravel()]
            return texts[0] if value.ndim == 0 else texts
        if isinstance(value, np.ndarray) and value.size == 1:
            return value.ravel()[0].item()
        return value.item() if isinstance(value, np.generic) else value

    def unit(self, name: str) -> str:
        """Returns the attribute `unit` of a dataset; empty if it has none. InputError if there is no such dataset."""
        return str(self.attribute(name, "unit") or "")


def _to_text(value: Any) -> str:
    return (value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)).rstrip(" \0")
