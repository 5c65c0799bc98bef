# SPDX-License-Identifier: BSD-3-Clause
"""For pvpython: a file as each of ParaView's XDMF readers sees it."""

from paraview import servermanager, simple

# what the Xdmf2 reader calls its file and what the others do
READERS = {"XDMFReader": "FileNames", "Xdmf3ReaderS": "FileName", "Xdmf3ReaderT": "FileName"}


def read_with_each(path):
    """Name of each reader, the reader at the first time, and the only grid in what it hands out."""
    for name, option in READERS.items():
        reader = getattr(simple, name)(**{option: [path]})
        reader.UpdatePipeline(1.0)
        data = servermanager.Fetch(reader)
        while data.IsA("vtkMultiBlockDataSet"):
            data = data.GetBlock(0)
        yield name, reader, data
