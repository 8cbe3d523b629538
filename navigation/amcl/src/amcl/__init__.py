"""amcl: finds a robot in a known map, by particles."""
