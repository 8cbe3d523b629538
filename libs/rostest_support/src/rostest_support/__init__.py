"""What the rostests, the bench and the stress campaign share."""
