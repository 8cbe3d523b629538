"""The page for browsers: its server, and the programs that open its panels."""
