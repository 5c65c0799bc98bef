# SPDX-License-Identifier: BSD-3-Clause
"""Model and snapshot files changed in place, with a seal that fits again: what one who wants to deceive would do."""

import h5py


def change(path, how):
    """Calls how(file) with the HDF5 file opened for changes, and then seals it again."""
    with h5py.File(path, "r+") as file:
        how(file)
    seal(path)


def seal(path):
    """Writes length and checksum (FNV-1a, 64 bits) of all that follows into the first 512 bytes of a file."""
    content = path.read_bytes()[512:]
    checksum = 0xCBF29CE484222325
    for byte in content:
        checksum = ((checksum ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    text = f"SIGNOROM SEAL 1\nbytes {len(content)}\nfnv1a {checksum:016x}\n".encode()
    path.write_bytes(text.ljust(512, b"\0") + content)
