"""teleop_twist_keyboard: drive a robot with the keys of a terminal."""
