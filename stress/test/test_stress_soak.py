"""What the soak takes for a node's memory."""
import mmap
import os
import tempfile

import pytest

import stress_soak

SIZE = 50_000_000  # [bytes]


def test_own_memory_is_what_a_process_fills():
    """And not the part of a file's pages that falls to it, which changes with what other programs do."""
    before = stress_soak.own_memory(os.getpid())
    kept = bytearray(b'x') * SIZE
    assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
    with tempfile.TemporaryFile(dir='/var/tmp') as file:  # on a disk: what lies in a tmpfs is memory
        file.write(kept)
        file.flush()
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        assert mapped.find(b'y') == -1  # reads all pages
        assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
