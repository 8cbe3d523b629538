"""A pytest plugin: which tests there are, of which kind, and what they need."""
