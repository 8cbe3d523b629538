#!/usr/bin/env python3
from actionlib_tutorials.fibonacci import main
from rospy_support import nodes

if __name__ == '__main__':
    nodes.run(main)
