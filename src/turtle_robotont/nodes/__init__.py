"""The course's nodes."""
