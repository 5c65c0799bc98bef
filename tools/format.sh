#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Formats all sources in place.
set -euo pipefail
. "$(dirname "$0")/common.sh"

tools=build/venv/bin
[ -x $tools/ruff ] || fail "no formatters in $tools; run: tools/install_dependencies.sh --test"
find src include tests \( -name '*.c' -o -name '*.h' ! -name macros.h \) -exec clang-format -i {} +
find src tests include \( -name '*.f90' -o -name '*.F90' -o -name '*.pf' \) -exec $tools/python tools/format_fortran.py {} +
$tools/ruff check --quiet --fix . || true
$tools/ruff format --quiet .
