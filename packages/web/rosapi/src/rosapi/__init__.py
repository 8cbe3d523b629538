"""rosapi: services that tell about topics, services, nodes, types and parameters."""
