# SPDX-License-Identifier: BSD-3-Clause
"""Model and snapshot files changed in place, with a seal that fits again: what one who wants to deceive would do."""

import ctypes
import functools
import subprocess
import tempfile
from pathlib import Path

import h5py

# FNV-1a, 64 bits (Fowler, Noll, Vo); Python takes a hundred times as long for it
FNV_1A = """
#include <stdint.h>
#include <stddef.h>
uint64_t fnv_1a(const unsigned char *bytes, size_t n)
{
  uint64_t sum = 0xCBF29CE484222325u;
  for (size_t i = 0; i < n; i++) sum = (sum ^ bytes[i]) * 0x100000001B3u;
  return sum;
}
"""


@functools.cache
def fnv_1a():
    """The function, compiled."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fnv_1a.so"
        command = ["cc", "-O2", "-shared", "-fPIC", "-x", "c", "-", "-o", path]
        subprocess.run(command, input=FNV_1A, text=True, check=True)
        function = ctypes.CDLL(str(path)).fnv_1a
    function.restype, function.argtypes = ctypes.c_uint64, (ctypes.c_char_p, ctypes.c_size_t)
    return function


def change(path, how):
    """Calls how(file) with the HDF5 file opened for changes, and then seals it again."""
    with h5py.File(path, "r+") as file:
        how(file)
    seal(path)


def seal(path):
    """Writes length and checksum (FNV-1a, 64 bits) of all that follows into the first 512 bytes of a file."""
    content = path.read_bytes()[512:]
    checksum = fnv_1a()(content, len(content))
    text = f"SIGNOROM SEAL 1\nbytes {len(content)}\nfnv1a {checksum:016x}\n".encode()
    path.write_bytes(text.ljust(512, b"\0") + content)
