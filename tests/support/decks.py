# SPDX-License-Identifier: BSD-3-Clause
"""Copies of test decks, changed where a test wants them to be."""

import re
from pathlib import Path


def copy_deck(source, folder, **replacements):
    """Copies a deck into a folder, and returns the path of the copy.

    A mesh path that starts with ../ becomes absolute. `replacements`: each text is replaced by another one everywhere;
    AssertionError if the deck does not have it. Results go to folder/results/<name> when the program runs there.
    """
    text = re.sub(
        r"\.\./\S+\.msh", lambda path: str((source.parent / path.group()).resolve()), source.read_text()
    )
    for old, new in replacements.items():
        assert old in text, f"{source.name} has no {old}"
        text = text.replace(old, new)
    path = Path(folder) / source.name
    path.write_text(text)
    return path


def write_held_blocks(path, n_dim, contact):
    """Writes a deck of the blocks in blocks.msh beside it to `path`, and returns the path.

    All components are held at the bottom; the top moves along -y by the parameter `stroke` (0 to 0.5), and is held
    otherwise. `contact` is the text of that section.
    """
    held = ", ".join(f"{axis}: 0" for axis in "xyz"[:n_dim])
    path.write_text(
        f"mesh: {{file: blocks.msh, model: {'plane_strain' if n_dim == 2 else 'solid'}}}\n"
        "parameters: {stroke: {min: 0, max: 0.5}}\n"
        "materials: {block: {regions: [lower, upper], young_modulus: 2.0e6, poisson_ratio: 0.3}}\n"
        "boundary_conditions:\n"
        f"  - {{boundary: bottom, displacement: {{{held}}}}}\n"
        f"  - {{boundary: top, displacement: {{{held.replace('y: 0', 'y: -stroke')}}}}}\n"
        f"{contact}\n"
    )
    return path
