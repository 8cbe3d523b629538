"""ALVAR markers without ROS: their code, finding them in pictures, their poses, and following them over frames."""
