"""What tests of commands share."""

import gc
import tracemalloc

import pytest

from luenberger.formats import csv_table
from luenberger.run import tables


@pytest.fixture
def peaks(monkeypatch):
    """The most memory that each record took, in bytes, read in pieces of 32 KiB."""
    found, write = [], tables.write

    def each(rows):
        for piece in rows:
            gc.collect()  # what is let go of counts no more, and when hangs on the rest
            yield piece

    def traced(out, header, rows):
        tracemalloc.start()
        try:
            return write(out, header, each(rows))
        finally:
            found.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()

    monkeypatch.setattr(csv_table.Table.__init__, "__defaults__", (1 << 15,))
    monkeypatch.setattr(tables, "write", traced)
    return found
