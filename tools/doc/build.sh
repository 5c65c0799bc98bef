#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the documentation site into a folder: tools/doc/build.sh build/doc, then open build/doc/html/index.html.
set -euo pipefail
. "$(dirname "$0")/../common.sh"

folder=${1:?usage: tools/doc/build.sh FOLDER}
python=build/venv/bin/python
if ! command -v doxygen >/dev/null || ! $python -c 'import breathe, furo, myst_parser, sphinx' 2>/dev/null; then
  echo "Packages for the documentation are missing. Run: tools/install_dependencies.sh --doc" >&2
  exit 77 # ctest: left out
fi
$python tools/doc/build.py "$folder"
