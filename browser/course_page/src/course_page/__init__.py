"""The page for browsers: its server, and what opens its panels."""
