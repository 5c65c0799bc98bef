#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Checks formats and house rules; changes nothing (tools/format.sh does). --fast leaves out fprettify, the slow one.
set -uo pipefail
. "$(dirname "$0")/common.sh" || exit 1

tools=build/venv/bin
[ -x $tools/ruff ] || fail "no lint tools in $tools; run: tools/install_dependencies.sh --test"
is_fast=0
[ "${1:-}" = --fast ] && is_fast=1
failed=()

# Runs one check and remembers a failure, so that one run shows all.
check() {
  local name=$1
  shift
  printf -- '-- %s\n' "$name"
  "$@" || failed+=("$name")
}

mapfile -t fortran < <(find src tests include \( -name '*.f90' -o -name '*.F90' \) | sort)
mapfile -t tests < <(find tests -name '*.pf' | sort)
# macros.h is Fortran
mapfile -t c_files < <(find src include tests \( -name '*.c' -o -name '*.h' ! -name macros.h \) | sort)
mapfile -t scripts < <(find tools .ci input -name '*.sh' -o -name '*.slurm' -o -path .ci/run | sort)

shell_syntax() {
  local script
  for script in "${scripts[@]}"; do bash -n "$script" || return 1; done
}

check 'house rules (tools/check_style.py)' /usr/bin/python3 tools/check_style.py
check 'documentation (tools/doc/build.py --check)' /usr/bin/python3 tools/doc/build.py --check
check 'clang-format' clang-format --dry-run --Werror "${c_files[@]}"
check 'ruff' $tools/ruff check --quiet .
check 'ruff format' $tools/ruff format --check --quiet .
check 'codespell' $tools/codespell .
# what it says about PETSc's type macros in .F90 files is on standard error, and expected
check 'fortitude' $tools/fortitude check --quiet --output-format concise "${fortran[@]}" 2> >(grep -v '^warning: Syntax errors' >&2)
check 'shell syntax' shell_syntax
check 'planted errors (tests/mutation)' $tools/python tests/mutation/run.py --check
if [ $is_fast = 0 ]; then
  check 'fprettify (tools/format_fortran.py)' $tools/python tools/format_fortran.py --check "${fortran[@]}" "${tests[@]}"
fi

if [ ${#failed[@]} -gt 0 ]; then
  printf 'lint failed: %s\n' "${failed[@]}" >&2
  echo 'tools/format.sh mends what is a matter of format.' >&2
  exit 1
fi
echo 'lint passed'
