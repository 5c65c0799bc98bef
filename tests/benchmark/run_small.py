# SPDX-License-Identifier: BSD-3-Clause
"""One benchmark as a test: `run_small.py FIGURE COMMAND...` fails where the command fails or prints no FIGURE.

FIGURE is a regular expression of what it must print; in it, # stands for a number. No time is judged.
"""

import re
import subprocess
import sys

NUMBER = r"[-+]?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?"


def main():
    """Runs the command and shows what it prints."""
    figure, *command = sys.argv[1:]
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode}")
    if not re.search(figure.replace("#", NUMBER), done.stdout):
        sys.exit(f"it prints no {figure}")


if __name__ == "__main__":
    main()
