# SPDX-License-Identifier: BSD-3-Clause
"""Mutations of any bytes and any text: what every kind of file has in common."""

import random
import re
import struct

NUMBERS = (
    "0 -0 -1 1 2 3 7 255 65536 2147483647 2147483648 -2147483648 -2147483649 4294967295 4294967296 "
    "9223372036854775807 9223372036854775808 -9223372036854775808 18446744073709551616 0.5 -0.5 1e-320 "
    "1e-300 1e300 1e308 1e309 -1e309 nan -nan inf -inf Infinity 0x10 1e 1e+ .5 5. . - + 1d3 1D3 1,5 1_000 00012 0.1.2 "
    "99999999999999999999999999999999999999"
).split()
INTEGERS = [
    0,
    1,
    2,
    3,
    4,
    5,
    8,
    127,
    255,
    256,
    65535,
    2**20,
    2**24,
    2**30,
    2**31 - 1,
    2**31,
    2**32 - 1,
    2**32,
    2**62,
    2**63 - 1,
]
REALS = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1e-320,
    1e-300,
    1e150,
    1e308,
    -1e308,
    float("inf"),
    float("-inf"),
    float("nan"),
]
ODD_TEXT = [
    "",
    " ",
    "\t",
    "\r",
    "\n",
    "\0",
    "\x1b[31m",
    "\u00e9",
    "\u2028",
    "\ufeff",
    "'",
    '"',
    "\\",
    "%s",
    "%n",
    "$",
    "#",
    "~" * 300,
]
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def number_of(rng: random.Random) -> str:
    """A number that readers do not like, or one of common size."""
    kind = rng.random()
    if kind < 0.7:
        return rng.choice(NUMBERS)
    if kind < 0.85:
        return str(rng.randint(-20, 20))
    return repr(rng.uniform(-2, 2))


def replace_number(data: bytes, rng: random.Random) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    match = rng.choice(found)
    return data[: match.start()] + number_of(rng).encode() + data[match.end() :]


def change_bytes(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 8))):
        if changed:
            changed[rng.randrange(len(changed))] = rng.choice(
                (0, 9, 10, 13, 32, 127, 128, 255, rng.randrange(256))
            )
    return bytes(changed)


def insert_text(data: bytes, rng: random.Random) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] + rng.choice(ODD_TEXT).encode() + data[at:]


def cut_piece(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return data
    start = rng.randrange(len(data))
    return data[:start] + data[start + rng.choice((1, 2, 4, 8, rng.randint(1, len(data)))) :]


def double_piece(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return data
    start = rng.randrange(len(data))
    piece = data[start : start + rng.choice((1, 2, 4, 8, rng.randint(1, 200)))]
    return data[:start] + piece * rng.choice((1, 1, 2, 50)) + data[start:]


def end_early(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randint(0, len(data))]


def rearrange_lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    action = rng.randrange(5)
    if action == 0:
        lines[i], lines[j] = lines[j], lines[i]
    elif action == 1:
        del lines[min(i, j) : max(i, j)]
    elif action == 2:
        lines.insert(i, lines[j])
    elif action == 3:
        lines.insert(rng.randrange(len(lines)), lines.pop(i))
    else:
        del lines[i]
    return b"\n".join(lines)


def swap_words(data: bytes, rng: random.Random) -> bytes:
    words = list(re.finditer(rb"[^\s,:{}\[\]]+", data))
    if len(words) < 2:
        return data
    first, second = sorted(rng.sample(words, 2), key=lambda match: match.start())
    return (
        data[: first.start()]
        + second.group()
        + data[first.end() : second.start()]
        + (first.group() if rng.random() < 0.5 else second.group())
        + data[second.end() :]
    )


def poke_number(data: bytes, rng: random.Random) -> bytes:
    """Writes a 4- or 8-byte number over what is there, more often than not at a multiple of 4."""
    if len(data) < 8:
        return data
    at = rng.randrange(len(data) - 7)
    if rng.random() < 0.7:
        at -= at % 4
    kind = rng.randrange(3)
    if kind == 0:
        piece = struct.pack("<i", (rng.choice(INTEGERS) * rng.choice((1, -1)) + 2**31) % 2**32 - 2**31)
    elif kind == 1:
        piece = struct.pack("<q", rng.choice(INTEGERS) * rng.choice((1, -1)))
    else:
        piece = struct.pack("<d", rng.choice(REALS))
    return data[:at] + piece + data[at + len(piece) :]


TEXT_MUTATIONS = [replace_number] * 5 + [rearrange_lines] * 4 + [swap_words] * 3
TEXT_MUTATIONS += [change_bytes, insert_text, cut_piece, double_piece, end_early]
BINARY_MUTATIONS = [poke_number] * 6 + [change_bytes, change_bytes, cut_piece, double_piece, end_early]


def several(mutations: list, data: bytes, rng: random.Random) -> bytes:
    """One mutation, sometimes more of them one after the other."""
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 6))):
        data = rng.choice(mutations)(data, rng)
    return data
