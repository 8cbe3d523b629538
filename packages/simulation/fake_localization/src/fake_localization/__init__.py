"""The true pose of a simulated robot as amcl would publish it; see README.md."""
