"""Helpers for rostests and tools/bench."""
