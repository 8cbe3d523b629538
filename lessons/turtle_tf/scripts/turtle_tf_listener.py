#!/usr/bin/env python3
from rospy_support import nodes
from turtle_follower.follower import main

if __name__ == '__main__':
    nodes.run(lambda: main('turtle_tf_listener'))
