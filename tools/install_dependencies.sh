#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs what is missing: Debian packages (as root, or with sudo) and the Python tool in build/venv.
# With --test also what lint and tests need, with --doc what the documentation site needs. Does nothing where everything is there.
set -euo pipefail
. "$(dirname "$0")/common.sh"

is_test=0
is_doc=0
for option in "$@"; do
  case $option in
  --test) is_test=1 ;;
  --doc) is_doc=1 ;;
  *) fail "usage: tools/install_dependencies.sh [--test] [--doc]" ;;
  esac
done

packages=(
  gcc gfortran cmake ninja-build pkg-config # build
  libopenmpi-dev openmpi-bin
  libpetsc-real-dev libslepc-real-dev
  libopenblas0-serial # without it PETSc runs on the reference BLAS, six times slower
  liblapack-dev libmetis-dev libmumps-dev libhdf5-dev libfyaml-dev libmuparser-dev
  python3 python3-venv # figures
  libgl1 libegl1 # VTK draws without a screen
)
optional_packages=(gmsh) # the meshes made from meshes/*.geo are committed, too
# forest: scikit-learn, for clusters of scattered snapshots; explore: trame and VTK, for a model in a browser
requirements=(-e 'tools/signorom_post[forest,explore]')
if [ $is_test = 1 ]; then
  packages+=(clang-format g++) # a host in C++
  optional_packages+=(chromium) # shows the pages of signorom-post report and explore
  requirements=(-e 'tools/signorom_post[test]' -r tools/requirements-test.txt)
fi
[ $is_doc = 0 ] || packages+=(doxygen)

# libpetsc-real-dev only points to libpetsc-real3.18-dev, which serves as well.
is_installed() {
  local names=("$1")
  case $1 in *-real-dev) names+=("${1%-dev}[0-9]*-dev") ;; esac
  # dpkg-query fails where one of the names is unknown, so only what it prints counts
  (dpkg-query --show --showformat '${db:Status-Status}\n' "${names[@]}" 2>/dev/null || true) | grep -x installed >/dev/null
}

# Those of the arguments that are not installed, one per line.
missing_of() {
  local package
  for package in "$@"; do is_installed "$package" || echo "$package"; done
}

# Runs a command as root, or fails where that cannot be done without a password that nobody types.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
    sudo "$@"
  else
    return 77
  fi
}

# What apt says is shown where it fails only: the set-up of some Debian packages prints errors that are none.
apt_install() {
  local options=(-o DPkg::Lock::Timeout=600) log=build/apt.log status=0 # another apt may be at work
  mkdir -p build
  echo "(minutes; what apt says goes to $log)"
  {
    as_root env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}" update -qq &&
      as_root env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}" install --yes -qq --no-install-recommends "$@"
  } >$log 2>&1 || status=$?
  [ $status = 0 ] || cat $log >&2
  return $status
}

install_packages() {
  local missing status=0
  command -v dpkg-query >/dev/null || fail "This script knows Debian only. Install what stands for: ${packages[*]} ${optional_packages[*]}"
  mapfile -t missing < <(missing_of "${packages[@]}" "${optional_packages[@]}")
  if [ ${#missing[@]} = 0 ]; then
    echo "Debian packages: all there"
    return
  fi
  echo "Debian packages to install: ${missing[*]}"
  apt_install "${missing[@]}" || status=$?
  mapfile -t missing < <(missing_of "${packages[@]}")
  if [ ${#missing[@]} -gt 0 ]; then
    [ $status = 77 ] || echo "apt-get failed (see above)." >&2
    fail "Packages are missing. Run this as root, then start again:
  apt-get update && apt-get install --yes --no-install-recommends ${missing[*]} ${optional_packages[*]}"
  fi
}

# Debian chooses the BLAS of all programs by update-alternatives; another one is slower or starts threads of its own.
check_blas() {
  local library blas
  for library in libblas.so.3 liblapack.so.3; do
    blas=$(readlink -f /usr/lib/"$(gcc -print-multiarch)"/$library || true)
    case $blas in
    */openblas-serial/*) ;;
    *) echo "Note: $library is $blas, not OpenBLAS (serial). Solving will be slower. To choose it:
  update-alternatives --config $library-$(gcc -print-multiarch)" ;;
    esac
  done
}

# Python compiles a module when it is first imported; most of the packages' modules never are.
pip_install() {
  PIP_DISABLE_PIP_VERSION_CHECK=1 build/venv/bin/python -m pip install --quiet --no-compile "$@" ||
    fail "pip could not install the Python packages; is a package index reachable?"
}

# uv installs what tests need in a quarter of pip's time. It does not read pip's settings: where it fails, pip tries.
install_python_packages() {
  [ $is_test = 1 ] && pip_install uv==0.13.9 && build/venv/bin/uv pip install --quiet --python build/venv/bin/python "$@" || pip_install "$@"
}

# /usr/bin/python3 by name: another python3 may stand first in PATH.
make_venv() {
  local venv=build/venv stamp=build/venv/signorom-requirements wanted
  wanted=$(printf '%s\n' "$PWD" "${requirements[@]}"; /usr/bin/python3 --version; cat tools/requirements-test.txt tools/signorom_post/pyproject.toml)
  if [ -x $venv/bin/signorom-post ] && [ "$(cat $stamp 2>/dev/null)" = "$wanted" ]; then
    echo "Python environment: up to date ($venv)"
    return
  fi
  # what the tests need is more than what the demo needs: do not take it away again
  if [ $is_test = 0 ] && [ -x $venv/bin/signorom-post ] && grep -qs -- '-r' $stamp; then
    echo "Python environment: there ($venv)"
    return
  fi
  echo "Python environment: installing into $venv"
  mkdir -p build
  /usr/bin/python3 -m venv $venv
  install_python_packages "${requirements[@]}"
  printf '%s\n' "$wanted" >$stamp
}

install_packages
check_blas
make_venv
[ $is_doc = 0 ] || install_python_packages -r tools/requirements-doc.txt
