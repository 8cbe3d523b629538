#!/usr/bin/env python3
"""The page that shows and drives the course in a browser."""
from rospy_support import nodes
from turtle_robotont.nodes.page_server import main

if __name__ == '__main__':
    nodes.run(main)
