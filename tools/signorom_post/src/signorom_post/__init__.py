# SPDX-License-Identifier: BSD-3-Clause
"""Figures and tables from the results of Signorom."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("signorom-post")
except PackageNotFoundError:  # run from the sources, not installed
    __version__ = "not installed"
