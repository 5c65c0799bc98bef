# SPDX-License-Identifier: BSD-3-Clause
"""Shards, snapshots.h5 and model.h5: mutations that keep checksums right, so that what stands behind them is reached."""

import contextlib
import random
import struct
from pathlib import Path

import h5py
import numpy as np
from mutations import BINARY_MUTATIONS, INTEGERS, REALS, several

MASK = 2**64 - 1
SEED = 0xCBF29CE484222325
HEADER = 72
LARGEST = 10**6  # entries of a data set that is read as a whole
N_VALUES = 2 + 3 + 1 + 8  # doubles of a record of fuzz_seeds.f90


def fnv1a(data: bytes, value: int = SEED) -> int:
    """FNV-1a of 64 bits, as src/files/checksum.c."""
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 & MASK
    return value


def hash_of_doubles(data: bytes) -> int:
    """Four chains over the words, as src/files/checksum.c."""
    words = struct.unpack(f"<{len(data) // 8}Q", data)
    chains = [SEED, SEED + 1, SEED + 2, SEED + 3]
    n_four = len(words) // 4 * 4
    for i, word in enumerate(words):
        chain = i % 4 if i < n_four else 0
        mixed = (chains[chain] ^ word) * 0x9E3779B97F4A7C15 & MASK
        chains[chain] = mixed ^ mixed >> 32
    return fnv1a(struct.pack("<4Q", *chains))


def mutate_shard(data: bytes, rng: random.Random) -> bytes:
    """Spoils header or records; mends their checksums in half of the cases."""
    header, records = bytearray(data[:HEADER]), data[HEADER:]
    size = 8 * (N_VALUES + 1)
    rows = [bytearray(records[i : i + size]) for i in range(0, len(records), size)]
    kind = rng.random()
    if kind < 0.3 and len(header) == HEADER:
        header = (
            bytearray(several(BINARY_MUTATIONS, bytes(header[:64]), rng)[:64].ljust(64, b"\0")) + header[64:]
        )
        if rng.random() < 0.5:
            header[64:] = struct.pack("<Q", fnv1a(bytes(header[:64])))
    elif kind < 0.7 and rows:
        row = rows[rng.randrange(len(rows))]
        row[: 8 * N_VALUES] = several(BINARY_MUTATIONS, bytes(row[: 8 * N_VALUES]), rng)[
            : 8 * N_VALUES
        ].ljust(8 * N_VALUES, b"\0")
        if rng.random() < 0.5:
            row[8 * N_VALUES :] = struct.pack("<Q", hash_of_doubles(bytes(row[: 8 * N_VALUES])))
    elif kind < 0.85 and rows:
        rows.insert(rng.randrange(len(rows)), rows.pop(rng.randrange(len(rows))))
        rows += rows[: rng.choice((0, 1, 3))]
    else:
        return several(BINARY_MUTATIONS, data, rng)
    return bytes(header) + b"".join(map(bytes, rows))


class Hdf5:
    """Changes a copy of a file through the HDF5 library, so that it stays HDF5; now and then its bytes, too."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "changed.h5"

    def mutate(self, data: bytes, rng: random.Random) -> bytes:
        if rng.random() < 0.15:
            return several(BINARY_MUTATIONS, data, rng)
        self.path.write_bytes(data)
        with h5py.File(self.path, "r+") as file:
            for _ in range(rng.choice((1, 1, 1, 2, 3))):
                # what the library does not take is no change
                with contextlib.suppress(ValueError, KeyError, TypeError, RuntimeError, OSError):
                    change_item(file, rng)
        return self.path.read_bytes()


def change_item(file: h5py.File, rng: random.Random) -> None:
    """One data set, one group or one attribute."""
    names: list[str] = []
    file.visit(names.append)
    if not names:
        return
    name = rng.choice(names)
    kind = rng.random()
    if kind < 0.15:
        change_attribute(rng.choice([file, file[name]]), rng)
    elif isinstance(file[name], h5py.Dataset):
        change_dataset(file, name, rng)
    elif kind < 0.6:
        link_item(file, name, rng.choice(names), rng)


def change_attribute(item: h5py.Group | h5py.Dataset, rng: random.Random) -> None:
    if not item.attrs:
        return
    name = rng.choice(sorted(item.attrs))
    action = rng.randrange(4)
    if action == 0:
        del item.attrs[name]
    elif action == 1:
        item.attrs[name] = np.int64(rng.choice(INTEGERS) * rng.choice((1, -1)))
    elif action == 2:
        item.attrs[name] = np.int32(rng.randint(-2, 9))
    else:
        item.attrs[name] = rng.choice(
            ["", "x" * 5000, "\x1b[2J", np.zeros(3), np.zeros(0), h5py.Empty("f8"), 1e300]
        )


def change_dataset(file: h5py.File, name: str, rng: random.Random) -> None:
    action = rng.random()
    if (file[name].size or 0) > LARGEST:  # made by make_huge
        return
    values = file[name][()]
    if action < 0.5:
        replace(file, name, change_values(values, rng))
    elif action < 0.75:
        replace(file, name, change_shape(values, rng))
    elif action < 0.85:
        link_item(file, name, name, rng)
    elif action < 0.95:
        replace_by_other_type(file, name, values, rng)
    else:
        make_huge(file, name, rng)


def replace(file: h5py.File, name: str, values: object) -> None:
    attributes = dict(file[name].attrs)
    del file[name]
    file[name] = values
    for key, value in attributes.items():
        file[name].attrs[key] = value


def change_values(values: object, rng: random.Random) -> object:
    """Some entries become numbers that no reader likes, or entries of each other."""
    array = np.array(values)
    if array.dtype.kind not in "iuf" or array.size == 0:
        return change_text(values, rng)
    flat = array.reshape(-1)
    for _ in range(rng.choice((1, 1, 2, array.size))):
        i = rng.randrange(array.size)
        if array.dtype.kind == "f":
            flat[i] = rng.choice(REALS + [float(flat[rng.randrange(array.size)])])
        else:
            limits = np.iinfo(array.dtype)
            number = rng.choice(
                [
                    rng.choice(INTEGERS) * rng.choice((1, -1)),
                    int(flat[i]) + rng.choice((1, -1)),
                    rng.randint(-2, 6),
                ]
            )
            flat[i] = max(limits.min, min(limits.max, number))
    return array


def change_text(values: object, rng: random.Random) -> object:
    text = rng.choice(
        [b"", b"a", b"x" * 300, b"\0", b"\xff\xfe", b"1/(a-a)", b"squeeze^999", b"(", b"-1", b"x" * 20000]
    )
    if isinstance(values, bytes):
        return text
    array = np.array(values, dtype=object)
    if array.size:
        array.reshape(-1)[rng.randrange(array.size)] = text
    return array.astype(h5py.string_dtype()) if array.size else array.astype("f8")


def change_shape(values: object, rng: random.Random) -> object:
    """A row more or less, another order of dimensions, nothing at all."""
    array = np.array(values)
    if array.dtype.kind not in "iuf":
        return values
    action = rng.randrange(6)
    if array.ndim == 0:
        return array.reshape(1) if action < 3 else np.zeros(action, array.dtype)
    if action == 0:
        return array[:-1]
    if action == 1:
        return np.concatenate([array, array[-1:]])
    if action == 2:
        return array.T.copy()
    if action == 3:
        return array[:0]
    if action == 4:
        return array.reshape(-1)
    return array.reshape((1, *array.shape))


def replace_by_other_type(file: h5py.File, name: str, values: object, rng: random.Random) -> None:
    array = np.array(values)
    if array.dtype.kind in "iuf":
        replace(file, name, array.astype(rng.choice(["i1", "u8", "f4", ">f8", ">i4", "c16", "S3"])))
    else:
        replace(
            file,
            name,
            rng.choice([np.zeros(2), np.zeros((0, 3)), 5, h5py.Empty("f8"), np.array([b"ab", b"c"])]),
        )


def make_huge(file: h5py.File, name: str, rng: random.Random) -> None:
    """A shape that announces far more than the file holds."""
    n_dim = max(1, len(file[name].shape or ()))
    shape = [3] * n_dim
    shape[rng.randrange(n_dim)] = rng.choice([2**20, 2**31 - 1, 2**31, 2**33, 2**60])
    del file[name]
    file.create_dataset(
        name, shape=shape, dtype=rng.choice(["f8", "i4"]), chunks=tuple(min(n, 64) for n in shape)
    )


def link_item(file: h5py.File, name: str, other: str, rng: random.Random) -> None:
    """In place of an item: nothing, another one, a loop, a file outside."""
    action = rng.randrange(6)
    target = None
    if action == 0:
        target = file[other]
    elif action == 1:
        target = h5py.SoftLink("/" + other)
    elif action == 2:
        target = h5py.SoftLink("/" + name)
    elif action == 3:
        target = h5py.ExternalLink("/etc/passwd", "/x")
    del file[name]
    if action == 4:
        file.create_group(name)
    elif action == 5:
        file.create_dataset(name, shape=(4,), dtype="f8", external=[("/etc/hostname", 0, 32)])
    elif target is not None and name not in file:
        file[name] = target
