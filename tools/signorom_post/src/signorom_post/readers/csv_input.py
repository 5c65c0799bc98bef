# SPDX-License-Identifier: BSD-3-Clause
"""Reads a CSV file with a header line. Each error is an InputError: one sentence with the name of the file."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from signorom_post.arrays import FloatArray
from signorom_post.errors import InputError
from signorom_post.readers.hdf5_input import require_file


class CsvInput:
    """The whole table as text. A column is converted to numbers when it is read by `numbers`."""

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        """Reads a table.

        InputError if the file is missing or no CSV file, if a column of `columns` is missing, or if there is no row
        below the header.
        """
        self.path = path
        require_file(path)
        try:
            with path.open(newline="", encoding="utf-8") as file:
                reader = csv.reader(file)
                rows = [(reader.line_num, row) for row in reader if row]
        except (UnicodeDecodeError, csv.Error) as error:
            raise InputError(path, "this is not a CSV file") from error
        except OSError as error:
            raise InputError(path, f"the file cannot be read ({error.strerror})") from error
        self.header = [name.strip() for name in rows[0][1]] if rows else []
        missing = [name for name in columns if name not in self.header]
        if missing:
            raise InputError(path, f"the header lacks the columns {', '.join(missing)}")
        if len(rows) < 2:
            raise InputError(path, "there is a header but no row below it")
        # with the number of the line in the file, 1-based
        self._rows = rows[1:]

    def texts(self, name: str) -> list[str]:
        """Returns a column as texts, one per row, without blanks at both ends; empty lines are no rows.

        `name` must be in the header. InputError if a row has another number of values than the header.
        """
        i_column = self.header.index(name)
        for i_line, row in self._rows:
            if len(row) != len(self.header):
                sentence = f"has {len(row)} values for {len(self.header)} columns; is the file truncated?"
                raise InputError(self.path, f"line {i_line} {sentence}")
        return [row[i_column].strip() for _, row in self._rows]

    def numbers_or_none(self, name: str) -> FloatArray:
        """As `numbers`, with nan also where the program says `none`: there is no bound or no estimate."""
        return self._converted(name, {"": "nan", "none": "nan"})

    def numbers(self, name: str) -> FloatArray:
        """Returns a column as numbers, nan where a cell is empty; shape (n_rows).

        `name` must be in the header. InputError if a text is not a number, or if a row has another number of values
        than the header.
        """
        return self._converted(name, {"": "nan"})

    def _converted(self, name: str, words: dict[str, str]) -> FloatArray:
        texts = self.texts(name)
        values = np.empty(len(texts))
        for i_row, text in enumerate(texts):
            try:
                values[i_row] = float(words.get(text, text))
            except ValueError as error:
                sentence = f"line {self._rows[i_row][0]}, column '{name}': '{text}' is not a number"
                raise InputError(self.path, sentence) from error
        return values
