"""What the soak takes for a node's memory."""
import mmap
import os

import pytest

import stress_soak

SIZE = 50_000_000  # [bytes]


def test_own_memory_is_what_a_process_fills(tmp_path):
    """And not the part of a file's pages that falls to it, which changes with what other programs do."""
    before = stress_soak.own_memory(os.getpid())
    kept = bytearray(b'x') * SIZE
    assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
    (tmp_path / 'library').write_bytes(bytes(kept))
    with open(tmp_path / 'library', 'rb') as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
        assert mapped.find(b'y') == -1  # reads all pages
        assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
