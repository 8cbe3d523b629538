#!/usr/bin/env python3
from robotont_laserscan_to_distance.node import main
from rospy_support import nodes

if __name__ == '__main__':
    nodes.run(main)
