#!/usr/bin/env python3
"""The course's first service call: the colour and width of the turtle's pen, with turtle1/set_pen."""
import rospy

from kinematic_ros import nodes, params
from turtle_robotont.driver import run
from turtle_robotont.turtle_tasks import set_pen


def main():
    nodes.init_node('set_pen')
    r, g, b = (params.integer(name, default, minimum=0, maximum=255)
               for name, default in (('~r', 0), ('~g', 0), ('~b', 255)))
    width = params.integer('~width', 5, minimum=0, maximum=255, unit='px')
    off = params.boolean('~off', False)
    params.log_effective()
    set_pen('turtle1/set_pen', r, g, b, width, off)
    rospy.loginfo('Pen off' if off else f'Pen set to r: {r} g: {g} b: {b}, {width} px wide')


if __name__ == '__main__':
    run(main)
