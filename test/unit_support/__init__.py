"""Helpers of the unit tests. tools/bench measures with them, too: photos of markers and their scores, whole drives."""
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]  # all tests import it from here; rostests, from node_pages
