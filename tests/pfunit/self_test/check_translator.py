#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the translator must refuse, with the line that it must name."""

import subprocess
import sys
import tempfile
from pathlib import Path

TRANSLATOR = Path(__file__).parents[1] / "translate_pf.py"
HEAD = "module test_it\n  use funit\ncontains\n"
REFUSED = [
    (HEAD + "  subroutine one()\n  end subroutine\nend module\n", 1, "no @test"),
    ("module other\nuse funit\n@test\nsubroutine one()\n", 1, "must have the name of the file"),
    (HEAD + "@test\nsubroutine one()\n  @assertEquals(1, 1)\n", 6, "is not in the subset"),
    (HEAD + "@test\nsubroutine one()\n  @assertEqual(1, &\n", 6, "on one line"),
    (HEAD + "@test\nsubroutine one()\n  @assertEqual(1, 1) ! why\n", 6, "on one line"),
    (HEAD + "@test\nsubroutine one(this)\n", 5, "use pfunit"),
    (HEAD + "@test(npes=[1])\nsubroutine one()\n", 5, "MpiTestMethod"),
    (HEAD + "@test(cases=[1])\nsubroutine one()\n", 4, "is not in the subset"),
    (HEAD + "@test\ninteger function one()\n", 5, "comes 'subroutine"),
    (HEAD + "@suite(name='x')\n", 4, "is not in the subset"),
    (HEAD + "@test\nsubroutine " + 45 * "a" + "()\n", 5, "44 are allowed"),
    (HEAD + "@test\nsubroutine one()\nend subroutine\n@test\nsubroutine One()\n", 1, "two tests"),
]


def main():
    """Feeds each text to the translator."""
    complaints = []
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "test_it.pf"
        for text, line, message in REFUSED:
            source.write_text(text, encoding="utf-8")
            command = [
                sys.executable,
                TRANSLATOR,
                source,
                Path(folder) / "out.F90",
                "--shown-name",
                "test_it.pf",
            ]
            result = subprocess.run(command, capture_output=True, text=True, check=False)
            if not result.stderr.startswith(f"test_it.pf:{line}: error: ") or message not in result.stderr:
                complaints.append(f"expected line {line}, '{message}'; got {result.stderr!r}")
    sys.exit("\n".join(complaints) or 0)


if __name__ == "__main__":
    main()
