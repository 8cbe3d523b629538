#!/usr/bin/env python3
from rospy_support import nodes
from turtle_follower.carrot import moving as main

if __name__ == '__main__':
    nodes.run(lambda: main('dynamic_tf_broadcaster'))
