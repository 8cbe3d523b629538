"""Driving to goals: costmaps, paths through them, velocities along a path, and what to do when one of them fails."""
