"""Localisation in a known map: Monte Carlo localisation with an adaptive number of particles."""
