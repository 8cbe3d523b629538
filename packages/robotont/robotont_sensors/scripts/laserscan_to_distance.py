#!/usr/bin/env python3
from robotont_sensors.node import main
from rospy_support import nodes

if __name__ == '__main__':
    nodes.run(main)
