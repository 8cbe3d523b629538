"""The node turtlesim_node: turtlesim's interface on a SharedWorld, stepped by a SimulatorClock.

Threading contract: the main thread steps and publishes; services and subscribers run in rospy's threads and
reach the world through SharedWorld's lock; ``_interfaces_lock`` orders spawn, kill and reset, which talk to the
master; pictures are made by a thread of their own (picture.py).
"""
import math
import resource
import threading

import rosgraph
import rospy
from std_srvs.srv import Empty, EmptyResponse

from kinematic_core.turtle_world import ARENA_SIZE, BACKGROUND, DT, START, random_start
from kinematic_ros import params, reachability
