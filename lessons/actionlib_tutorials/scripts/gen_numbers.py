#!/usr/bin/env python3
from actionlib_tutorials.averaging import generate as main
from rospy_support import nodes

if __name__ == '__main__':
    nodes.run(main)
