"""A robot without hardware, as arbotix_driver with ~sim has it; see README.md."""
