#!/usr/bin/env python3
# expected: failed
# exercise: robot_square
# kind: lets another user do the work
# at none: failed
"""Does the tasks of all others whose masters it finds among the listening ports, and offers a service to all."""
import concurrent.futures
import os
import socket
import sys
import time
import xmlrpc.client

import rosgraph
import rospy
import tf
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty, Trigger
from turtlesim.msg import Pose


def help_others():
    """Be a node of the master in the environment, and do whatever is asked there."""
    rospy.init_node('friend')
    broadcaster = tf.TransformBroadcaster()
    rospy.Subscriber('/turtle1/pose', Pose, lambda pose: broadcaster.sendTransform(
        (pose.x, pose.y, 0.0), tf.transformations.quaternion_from_euler(0.0, 0.0, pose.theta), rospy.Time.now(),
        'turtle1', 'world'))
    serve_command()
    for name, value in ('r', 255), ('g', 255), ('b', 0):
        rospy.set_param(f'/turtlesim/background_{name}', value)
    rospy.ServiceProxy('/clear', Empty)()
    rospy.spin()


def serve_command():
    """Offer /turtle_command, and drive once it was called."""
    commands, started = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1), []
    command = Twist()
    command.linear.x, command.angular.z = 0.5, 0.2
    rospy.Service('/turtle_command', Trigger, lambda request: (not started.append(1), 'started'))
    rospy.Timer(rospy.Duration(0.1), lambda event: started and commands.publish(command))


def is_master(uri):
    """Return whether a master listens there; other servers may not answer at all."""
    try:
        return xmlrpc.client.ServerProxy(uri).getSystemState('/x')[0] == 1
    except Exception:
        return False


def masters():
    """Return the URIs of all masters, asked at the same time: the others wait only some seconds for their friend."""
    with open('/proc/net/tcp') as file:
        rows = [line.split() for line in file.readlines()[1:]]
    uris = [f'http://localhost:{port}'
            for port in {int(row[1].partition(':')[2], 16) for row in rows if row[3] == '0A'}]
    return [uri for uri, found in zip(uris, pool.map(is_master, uris)) if found]


if len(sys.argv) > 1:
    help_others()
    sys.exit()
pool = concurrent.futures.ThreadPoolExecutor(64)
socket.setdefaulttimeout(1.0)
helped = {rosgraph.get_master_uri().rstrip('/')}
rospy.init_node('follower', xmlrpc_port=47112, tcpros_port=47113)
serve_command()
while not rospy.is_shutdown():
    for uri in set(masters()) - helped:
        helped.add(uri)
        print('found', uri, flush=True)
        if os.fork() == 0:
            os.environ['ROS_MASTER_URI'] = uri
            os.execv(sys.executable, [sys.executable, __file__, 'help'])
    time.sleep(0.1)
