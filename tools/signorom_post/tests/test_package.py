# SPDX-License-Identifier: BSD-3-Clause
"""The package, the program and the library have one version."""

import re
import tomllib
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def test_version_is_that_of_the_program() -> None:
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    cmake = (PACKAGE.parents[1] / "CMakeLists.txt").read_text()
    found = re.search(r"project\(\s*signorom\s+VERSION\s+([\d.]+)", cmake)
    assert found
    assert project["version"] == found[1]
    header = (PACKAGE.parents[1] / "include" / "signorom.h").read_text()
    citation = (PACKAGE.parents[1] / "CITATION.cff").read_text()
    assert f"\nversion: {found[1]}\n" in citation
    assert f"\n## [{found[1]}] - " in (PACKAGE.parents[1] / "CHANGELOG.md").read_text()
    assert f'#define SIGNOROM_VERSION "{found[1]}"\n' in header


def test_each_source_names_its_license() -> None:
    for path in [*PACKAGE.glob("src/**/*.py"), *PACKAGE.glob("tests/*.py"), PACKAGE / "pyproject.toml"]:
        assert path.read_text().startswith("# SPDX-License-Identifier: BSD-3-Clause\n"), path
