# SPDX-License-Identifier: BSD-3-Clause
"""Figures and tables from the results of Signorom, and answers of its models."""

from importlib.metadata import PackageNotFoundError, version

from signorom_post.answer import (
    Answer,
    Cells,
    Fields,
    FreeMotionWarning,
    InaccurateFieldsWarning,
    ModelError,
    NoAnswerError,
    NotAcceptedWarning,
)
from signorom_post.answers import Answers
from signorom_post.history import History, NoHistoryError
from signorom_post.library import LibraryError
from signorom_post.online import Model
from signorom_post.points import ExtrapolationWarning

try:
    __version__ = version("signorom-post")
except PackageNotFoundError:  # run from the sources, not installed
    __version__ = "not installed"

__all__ = [
    "Answer",
    "Answers",
    "Cells",
    "ExtrapolationWarning",
    "Fields",
    "FreeMotionWarning",
    "History",
    "InaccurateFieldsWarning",
    "LibraryError",
    "Model",
    "ModelError",
    "NoAnswerError",
    "NoHistoryError",
    "NotAcceptedWarning",
    "__version__",
]
