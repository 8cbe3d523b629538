"""A pytest plugin that collects all tests, with their kinds and requirements."""
