"""Occupancy grids: the map itself, its files, and its comparison with the true walls."""
