"""Mapping while driving: scan matching, and particles that each have a map."""
