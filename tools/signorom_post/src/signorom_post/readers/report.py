# SPDX-License-Identifier: BSD-3-Clause
"""Reads report.yaml, which tells what a run found, and other YAML files, as nested dictionaries."""

from pathlib import Path
from typing import Any

import yaml

from signorom_post.errors import InputError
from signorom_post.readers.hdf5_input import require_file


def read_report(path: Path) -> dict[str, Any]:
    """Returns the sections of report.yaml, which depend on the commands that were run.

    InputError if the file is missing, cannot be read, is not YAML, or is not a mapping.
    """
    return read_sections(path, "report")


def read_sections(path: Path, kind: str) -> dict[str, Any]:
    """Returns the sections of a YAML file: key -> value.

    InputError if the file is missing, cannot be read, is not YAML, or is not a mapping. `kind`, such as `report`, names
    the file in the message of the last case.
    """
    require_file(path)
    try:
        sections = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.MarkedYAMLError as error:
        line = f" (line {error.problem_mark.line + 1})" if error.problem_mark else ""
        raise InputError(path, f"this is not YAML{line}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(path, "this is not YAML") from error
    except OSError as error:
        raise InputError(path, f"the file cannot be read ({error.strerror})") from error
    if not isinstance(sections, dict):
        raise InputError(path, f"this is not a {kind}: it has no sections")
    return sections
