#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The paper's two half disks, from a clone to figures: installs, builds, runs, draws. Minutes, no questions.
set -euo pipefail
. "$(dirname "$0")/common.sh"

deck=input/half_disks.yaml
results=results/half_disks
program=build/release/signorom

# The committed mesh is the one that the deck names; a fresh one shows that its source still gives it.
make_mesh() {
  local made=build/demo/half_disks.msh
  if ! command -v gmsh >/dev/null; then
    echo "gmsh is not there, so the committed meshes/half_disks.msh is used as it is."
    return
  fi
  mkdir -p build/demo
  # at another verbosity than the default gmsh places a few nodes elsewhere
  gmsh -2 -format msh41 meshes/half_disks.geo -o $made >build/demo/gmsh.log
  # gmsh writes the list of mirrored nodes behind $Periodic in any order; the program does not read it
  if cmp --silent <(sed '/^\$Periodic/,$d' $made) <(sed '/^\$Periodic/,$d' meshes/half_disks.msh); then
    echo "gmsh made meshes/half_disks.msh again, node for node."
  else
    echo "This gmsh makes a slightly different mesh ($made); the committed meshes/half_disks.msh is used."
  fi
}

run_program() {
  if [ "$n_cores" -ge 2 ]; then
    mpirun --oversubscribe --bind-to none -n 2 $program run $deck --benchmark
  else
    $program run $deck --benchmark
  fi
}

step "1/5 packages"
tools/install_dependencies.sh
step "2/5 build of the release preset"
cmake --preset release >build/cmake.log 2>&1 || { cat build/cmake.log >&2; fail "CMake failed."; }
cmake --build --preset release --target signorom signorom_online
step "3/5 mesh"
make_mesh
step "4/5 signorom run $deck"
run_program
step "5/5 figures"
build/venv/bin/signorom-post figures $results
step "done"
build/venv/bin/signorom-post summary $results
cat <<TEXT

To look at:
  $results/figures/       figures (PNG)
  $results/fields.xdmf    fields, for ParaView
  $results/report.yaml    sizes, errors, times, the deck with its defaults
  $results/model.h5       the reduced model; ask it: $program predict $results/model.h5 --at squeeze=0.2
TEXT
