#!/usr/bin/env python3
from rospy_support import nodes
from turtle_follower.points import main

if __name__ == '__main__':
    nodes.run(main)
