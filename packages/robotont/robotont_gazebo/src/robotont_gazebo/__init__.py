"""The simulator of a Robotont: worlds, camera, laser scanner and nodes."""
