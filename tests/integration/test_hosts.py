# SPDX-License-Identifier: BSD-3-Clause
"""Programs of others on the installed library: C, C++ and Fortran, by pkg-config and by CMake."""

import os
import re
import subprocess

import pytest

from c_programs import INCLUDE, SOURCES
from runs import train_shifted_disks

POINT = {"squeeze": 0.31, "shift": 0.02}
# [-] the programs print 12 digits
PRINTED = 1e-11
PRINTED_NAMES = ("contact force", "error of the displacement")
COMPILERS = {"c": ["cc", "-std=c11"], "cpp": ["c++", "-std=c++17"], "f90": ["gfortran", "-std=f2018"]}


@pytest.fixture(scope="module")
def model(signorom, tmp_path_factory):
    """A trained model."""
    changes = {"method: hhr": "method: condensed"}
    return train_shifted_disks(signorom, tmp_path_factory.mktemp("study"), **changes)


@pytest.fixture(scope="module")
def prefix(library, tmp_path_factory):
    """Where the library and what its hosts need are installed."""
    folder = tmp_path_factory.mktemp("prefix")
    build = library.parents[2]
    for component in ("library", "development"):
        command = ["cmake", "--install", build, "--prefix", folder, "--component", component]
        subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def told(post, model):
    """Sum of the contact forces and error of the displacement (-1: not known), by the Python interface."""
    answer = post.Model(model).query(**POINT)
    bound = answer.relative_displacement_bound
    return answer.multipliers.sum(), -1 if bound is None else bound


def pkg_config(prefix, *options):
    """What pkg-config says of the installed library."""
    places = ":".join(str(path.parent) for path in prefix.rglob("signorom_online.pc"))
    command = ["pkg-config", *options, "signorom_online"]
    environment = os.environ | {"PKG_CONFIG_PATH": places}
    return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout.split()


def ask(program, model):
    """Contact force and error of the displacement that a program prints."""
    command = [program, model, *map(str, POINT.values())]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return tuple(float(re.search(rf"{name} +(\S+)", done.stdout)[1]) for name in PRINTED_NAMES)


@pytest.mark.parametrize("language", COMPILERS)
def test_pkg_config_is_enough(language, prefix, model, told, tmp_path):
    """One command compiles a host, which finds the answer of the Python interface."""
    sources = [SOURCES / f"ask_model.{language}"]
    if language == "f90":
        sources = pkg_config(prefix, "--variable=fortran_source") + sources
    command = [*COMPILERS[language], "-Wall", "-Wextra", "-Werror", *sources]
    folder = pkg_config(prefix, "--variable=libdir")[0]
    command += [*pkg_config(prefix, "--cflags", "--libs"), f"-Wl,-rpath,{folder}", "-o", tmp_path / "ask"]
    subprocess.run(command, check=True, cwd=tmp_path)
    assert ask(tmp_path / "ask", model) == pytest.approx(told, rel=PRINTED)


def test_find_package_serves_c_cpp_and_fortran(prefix, model, told, tmp_path):
    command = ["cmake", "-G", "Ninja", "-S", SOURCES, "-B", tmp_path, f"-DCMAKE_PREFIX_PATH={prefix}"]
    subprocess.run(command, check=True, capture_output=True)
    subprocess.run(["cmake", "--build", tmp_path], check=True, capture_output=True)
    for language in ("c", "cpp", "f"):
        assert ask(tmp_path / f"ask_model_{language}", model) == pytest.approx(told, rel=PRINTED)


def test_older_version_is_refused_by_cmake(prefix, tmp_path):
    """Before 1.0 a host that was written for another minor version must say so."""
    text = (SOURCES / "CMakeLists.txt").read_text().replace("signorom 0.1", "signorom 0.2")
    (tmp_path / "CMakeLists.txt").write_text(text)
    command = ["cmake", "-G", "Ninja", "-S", tmp_path, "-B", tmp_path / "b", f"-DCMAKE_PREFIX_PATH={prefix}"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode != 0
    assert 'compatible with requested version "0.2"' in " ".join(done.stderr.split())


def arguments_in(text, pattern, last_word):
    """Names of functions and their arguments."""
    return {
        name: [re.search(last_word, argument)[0] for argument in arguments.split(",") if argument.strip()]
        for name, arguments in re.findall(pattern, text)
    }


def test_fortran_module_has_all_functions_of_the_header():
    header = re.sub(r"/\*.*?\*/|//[^\n]*", "", (INCLUDE / "signorom.h").read_text(), flags=re.DOTALL)
    module = (INCLUDE / "signorom.f90").read_text()
    in_c = arguments_in(header.replace("(void)", "()"), r"\b(signorom_\w+)\(([^)]*)\);", r"\w+\s*$")
    in_fortran = arguments_in(
        module, r"(?:function|subroutine) (signorom_\w+)\(([^)]*)\) bind\(c\)", r"\w+\s*$"
    )
    assert len(in_c) > 30
    assert in_fortran == in_c
    for name, value in re.findall(r"\b(SIGNOROM_\w+) = (\d+)", header):
        assert re.search(rf"\b{name} = {value}\b", module), name
