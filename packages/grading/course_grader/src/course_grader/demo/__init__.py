"""The whole course, played and measured."""
