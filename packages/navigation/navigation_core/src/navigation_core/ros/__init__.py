"""What the nodes of the room navigation share: maps, scans and poses as messages, and transforms."""
