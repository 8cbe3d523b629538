"""ALVAR markers without ROS: their code, finding them in pictures, poses, bundles, and making them."""
