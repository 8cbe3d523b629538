"""The scenes of the bench, which the tracker's tests show it."""

