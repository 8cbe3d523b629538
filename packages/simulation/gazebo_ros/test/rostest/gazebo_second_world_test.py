#!/usr/bin/env python3
"""Launch files of simulators, one after the other and beside each other, as they are typed in terminals."""
import signal
import tempfile
import unittest

import psutil
import rosnode
import rospy
from gazebo_msgs.srv import GetWorldProperties
from rosgraph_msgs.msg import Clock

from plain_support.processes import KILL
from rostest_support.common import Collected, Process, nightly, node_api, proxy, run, until

CTRL_C = ((signal.SIGINT, 30.0), *KILL)  # roslaunch waits for its nodes
PAUSED = """<launch>
  <param name="/use_sim_time" value="true"/>
  <node pkg="gazebo_ros" type="gzserver" name="gazebo" output="screen">
    <param name="paused" value="true"/> <param name="rate" value="2"/>
  </node>
</launch>"""
PLAIN = '<launch><node pkg="gazebo_ros" type="gzserver" name="gazebo" output="screen"/></launch>'


def parameters():
    """Return {name: value} of the master, without what roslaunch keeps there."""
    return {name: rospy.get_param(name) for name in rospy.get_param_names() if not name.startswith('/roslaunch/')}


def processes(*nodes):
    """Return the process of each node."""
    return [node_api(node).getPid('/test')[2] for node in nodes]


class SecondWorldTest(unittest.TestCase):

    def setUp(self):
        self.before = parameters()

    def launch(self, *arguments):
        process = Process('roslaunch', *arguments)
        self.addCleanup(process.stop, CTRL_C)
        return process

    def launch_text(self, text):
        file = tempfile.NamedTemporaryFile('w', suffix='.launch')
        self.addCleanup(file.close)
        file.write(text)
        file.flush()
        return self.launch(file.name)

    def assert_time_passes(self):
        clock = Collected('/clock', Clock)
        self.addCleanup(clock.subscriber.unregister)
        until(lambda: clock.messages and clock.messages[-1].clock > clock.messages[0].clock, 'time that passes')

    def assert_refused(self, *launched, by):
        """A launch ends by itself, and names the node that is there already."""
        process = self.launch(*launched)
        until(lambda: not process.runs(), lambda: f'the end of {launched}:\n{process.output()}')
        self.assertRegex(process.output(), f'does not start: {by} (has this name|has the services of /gazebo) already')

    def test_what_a_launch_was_told_the_next_one_does_not_do(self):
        first = self.launch('gazebo_ros', 'empty_world.launch', 'paused:=true')
        first.wait_for_output('Started paused, because the command line says so')
        first.stop(CTRL_C)
        self.assertEqual(self.before, parameters())
        second = self.launch('gazebo_ros', 'empty_world.launch')
        self.assert_time_passes()
        second.stop(CTRL_C)
        third = self.launch('gazebo_ros', 'empty_world.launch', 'use_sim_time:=false', 'rate:=2')
        third.wait_for_output('/gazebo/rate=2')
        third.stop(CTRL_C)
        self.assertEqual(self.before, parameters())

    @nightly
    def test_what_a_launch_file_sets_ends_with_it_and_what_a_killed_one_left_is_named(self):
        first = self.launch_text(PAUSED)
        first.wait_for_output('Started paused, because /gazebo/paused is true')
        children = psutil.Process(first.pid).children(recursive=True)
        first.process.kill()
        for child in children:
            child.kill()
        self.assertEqual((True, 2), (rospy.get_param('/gazebo/paused'), rospy.get_param('/gazebo/rate')))
        second = self.launch_text(PLAIN)
        second.wait_for_output('Started with paused=true, rate=2, because .* a run that was killed has left it')
        second.stop(CTRL_C)
        self.assertEqual(self.before, parameters())

    def test_a_second_world_leaves_a_robot_as_it_is(self):
        first = self.launch('robotont_gazebo', 'gazebo.launch')
        nodes = '/robotont_gazebo', '/robotont_camera', '/robot_state_publisher'
        first.wait_for_output('/robotont_gazebo/world=empty')
        until(lambda: set(nodes) <= set(rosnode.get_node_names()), 'its nodes')
        there, running = parameters(), processes(*nodes)
        self.assert_refused('robotont_gazebo', 'world_minimaze_ar.launch', 'model:=robotont_gazebo_lidar', 'rate:=2',
                            by='/robotont_gazebo')
        self.assert_refused('gazebo_ros', 'robotonts.launch', by='/robotont_gazebo')
        self.assertEqual((there, running), (parameters(), processes(*nodes)))
        first.stop(CTRL_C)
        self.assertEqual(self.before, parameters())

    @nightly
    def test_a_second_world_leaves_that_of_gzserver_as_it_is(self):
        first = self.launch('gazebo_ros', 'robotonts.launch', 'robots:=1')
        world = proxy('/gazebo/get_world_properties', GetWorldProperties)
        until(lambda: 'robot1' in world().model_names, 'the robot')
        nodes = '/gazebo', '/gazebo_cameras', '/robot1/robot_state_publisher'
        until(lambda: set(nodes) <= set(rosnode.get_node_names()), 'its nodes')
        there, running = parameters(), processes(*nodes)
        self.assert_refused('gazebo_ros', 'robotonts.launch', 'model:=robotont_gazebo_lidar', by='/gazebo')
        self.assert_refused('robotont_gazebo', 'gazebo.launch', by='/gazebo')
        self.assert_refused('gazebo_ros', 'empty_world.launch', 'use_sim_time:=false', by='/gazebo')
        self.assertEqual((there, running), (parameters(), processes(*nodes)))
        self.assertNotIn('robot2', world().model_names)
        self.assert_time_passes()
        first.stop(CTRL_C)
        self.assertEqual(self.before, parameters())


if __name__ == '__main__':
    run(SecondWorldTest)
