#!/usr/bin/env python3
"""The course's first service call: the colour and width of the turtle's pen, with turtle1/set_pen."""
import rospy

from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Integer, Table
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_tasks import set_pen

PARAMETERS = Table(Integer('~r', 0, 0, 255), Integer('~g', 0, 0, 255), Integer('~b', 255, 0, 255),
                   Integer('~width', 5, 0, 255, 'px'), Boolean('~off', False))


def main():
    nodes.init_node('set_pen', PARAMETERS)
    r, g, b, width, off = PARAMETERS.read('~r', '~g', '~b', '~width', '~off')
    parameters.log_effective()
    set_pen('turtle1/set_pen', r, g, b, width, off)
    rospy.loginfo('Pen off' if off else f'Pen set to r: {r} g: {g} b: {b}, {width} px wide')


if __name__ == '__main__':
    run(main)
