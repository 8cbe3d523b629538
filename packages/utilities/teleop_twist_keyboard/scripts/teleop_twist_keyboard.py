#!/usr/bin/env python3
from rospy_support import nodes
from twist_keyboard.node import main

if __name__ == '__main__':
    nodes.run(main)
