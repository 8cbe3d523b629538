"""Localisation in a known map by particles: Monte Carlo localisation with a number of particles that adapts."""
