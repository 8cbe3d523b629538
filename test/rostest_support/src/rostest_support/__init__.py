"""Helpers for rostests, the bench and the stress campaign."""
