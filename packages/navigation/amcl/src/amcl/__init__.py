"""amcl: finds a robot in a known map with a particle filter."""
