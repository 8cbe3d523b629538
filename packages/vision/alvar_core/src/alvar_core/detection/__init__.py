"""The detector: from an image to the ids, corners and poses of the markers in it, and their tracking over images."""
