# SPDX-License-Identifier: BSD-3-Clause
# What the scripts share; to be sourced. Sets the root as working directory, what Open MPI and BLAS need, and n_cores.
# shellcheck shell=bash disable=SC2034
cd "$(dirname "${BASH_SOURCE[0]}")/.."

n_cores=$(env -u OMP_NUM_THREADS nproc) # nproc takes OMP_NUM_THREADS for the number of cores
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none # containers forbid it, and Open MPI then fills the screen
export HWLOC_HIDE_ERRORS=2 # a container without /sys: nothing depends on it
if [ "$(id -u)" = 0 ]; then # Open MPI refuses to run as root unless told twice
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# Headline of a step, with the minutes since the start.
step() {
  printf '\n== %s (%d:%02d)\n' "$*" $((SECONDS / 60)) $((SECONDS % 60))
}

# Fails with a sentence.
fail() {
  printf '%s\n' "$*" >&2
  exit 1
}
