"""The scenes of the bench, which the tracker's tests show it."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), '..', '..', '..', 'bench'))
