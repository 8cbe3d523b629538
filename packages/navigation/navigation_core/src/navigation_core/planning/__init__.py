"""Driving to goals: costmaps, paths through them, velocities along a path, and recovery when one of them fails."""
