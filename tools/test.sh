#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# What CI runs and what a developer runs: lint, the ci build, every test. --fast leaves out what is labelled slow.
set -euo pipefail
. "$(dirname "$0")/common.sh"

lint_options=()
test_options=()
case ${1:-} in
--fast)
  lint_options=(--fast)
  test_options=(--label-exclude slow)
  export PYTEST_ADDOPTS="${PYTEST_ADDOPTS:-} -m 'not slow'"
  ;;
'') ;;
*) fail "usage: tools/test.sh [--fast]" ;;
esac

step "1/3 packages"
tools/install_dependencies.sh --test --doc
step "2/3 lint, and build of the ci preset"
# lint is one process, mostly: beside it the build has nearly two cores
tools/lint.sh ${lint_options[@]+"${lint_options[@]}"} >build/lint.log 2>&1 &
lint=$!
is_built=1
cmake --preset ci >build/cmake.log 2>&1 || { cat build/cmake.log >&2; is_built=0; }
[ $is_built = 0 ] || cmake --build --preset ci || is_built=0
is_clean=1
wait $lint || is_clean=0
cat build/lint.log
[ $is_built = 1 ] || fail "The build failed."
step "3/3 tests"
status=0
# one more than cores: many tests wait, for instance a second for mpirun after an error
ctest --preset ci --parallel $((n_cores + 1)) --no-tests=error ${test_options[@]+"${test_options[@]}"} </dev/null || status=$?
printf '\n(%d:%02d in all)\n' $((SECONDS / 60)) $((SECONDS % 60))
if [ $is_clean = 0 ]; then
  echo "lint failed: see step 2 above, or run tools/lint.sh" >&2
  status=1
fi
exit $status
