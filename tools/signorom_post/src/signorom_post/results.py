# SPDX-License-Identifier: BSD-3-Clause
"""A results folder. Each file is read once, at its first use."""

from functools import cached_property
from pathlib import Path
from typing import Any

from signorom_post.errors import InputError, MissingFileError
from signorom_post.readers.enrichment import History, read_enrichment
from signorom_post.readers.fields import FieldFile, read_fields
from signorom_post.readers.histories import PointHistory, read_histories
from signorom_post.readers.model import Model, read_model
from signorom_post.readers.report import read_report
from signorom_post.readers.snapshots import SnapshotSet, read_snapshots
from signorom_post.readers.surfaces import ContactSurfaces, read_surfaces, surfaces_of_fields
from signorom_post.readers.validation import Validation, read_validation


class Results:
    """The files in the results folder of one deck. An attribute raises InputError if its file cannot be used.

    This is a MissingFileError if there is no such file.
    """

    def __init__(self, folder: Path) -> None:
        """Keeps the path of the results folder `folder`; InputError if there is no such folder."""
        if not folder.exists():
            raise InputError(folder, "there is no such folder")
        if not folder.is_dir():
            raise InputError(folder, "this is not a folder; give the results folder of a deck")
        self.folder = folder

    @cached_property
    def fields(self) -> FieldFile:
        """Contents of fields.h5, read at the first use; InputError if the file is missing or cannot be used."""
        return read_fields(self.folder / "fields.h5")

    @cached_property
    def snapshots(self) -> SnapshotSet:
        """Contents of snapshots.h5, read at the first use; InputError if the file is missing or cannot be used."""
        return read_snapshots(self.folder / "snapshots.h5")

    @cached_property
    def model(self) -> Model:
        """Contents of model.h5, read at the first use; InputError if the file is missing or cannot be used."""
        return read_model(self.folder / "model.h5")

    @cached_property
    def surfaces(self) -> ContactSurfaces:
        """Contact surfaces of contact.h5 or, if it is missing or belongs to other points, of fields.h5; read once.

        InputError if a file cannot be used.
        """
        try:
            return read_surfaces(self.folder / "contact.h5", self.fields)
        except MissingFileError:
            return surfaces_of_fields(self.fields)

    @property
    def model_if_present(self) -> Model | None:
        """Contents of model.h5; None if the file is missing. InputError if it cannot be used."""
        try:
            return self.model
        except MissingFileError:
            return None

    @cached_property
    def enrichment(self) -> list[History]:
        """Contents of enrichment.csv, one history per cluster, read at the first use.

        InputError if the file is missing or cannot be used.
        """
        return read_enrichment(self.folder / "enrichment.csv")

    @cached_property
    def histories(self) -> list[PointHistory]:
        """Contents of history.csv, one entry per point; InputError if the file is missing or cannot be used."""
        return read_histories(self.folder / "history.csv")

    @cached_property
    def validation(self) -> Validation:
        """Contents of validation.csv, read at the first use; InputError if the file is missing or cannot be used."""
        return read_validation(self.folder / "validation.csv")

    @cached_property
    def report(self) -> dict[str, Any]:
        """Contents of report.yaml, read at the first use; InputError if the file is missing or cannot be used."""
        return read_report(self.folder / "report.yaml")
