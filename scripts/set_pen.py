#!/usr/bin/env python3
"""The course's first service call: the colour and width of the turtle's pen, with turtle1/set_pen."""
import rospy

from rospy_support import nodes, parameters
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_tasks import set_pen


def main():
    nodes.init_node('set_pen')
    r, g, b = (parameters.integer(name, default, minimum=0, maximum=255)
               for name, default in (('~r', 0), ('~g', 0), ('~b', 255)))
    width = parameters.integer('~width', 5, minimum=0, maximum=255, unit='px')
    off = parameters.boolean('~off', False)
    parameters.log_effective()
    set_pen('turtle1/set_pen', r, g, b, width, off)
    rospy.loginfo('Pen off' if off else f'Pen set to r: {r} g: {g} b: {b}, {width} px wide')


if __name__ == '__main__':
    run(main)
