"""ALVAR markers without ROS: their code, detection, poses, bundles, drawing and printing."""
