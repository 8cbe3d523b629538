"""Helpers of the unit tests. tools/bench measures with them, too: photos of markers and their scores, whole drives."""
