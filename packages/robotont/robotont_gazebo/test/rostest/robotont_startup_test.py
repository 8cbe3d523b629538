#!/usr/bin/env python3
"""The simulated Robotont's start: worlds and parameters that cannot be, a second robot, time, repeatable runs."""
import tempfile
import time

import rosgraph
import roslib.packages
import rosnode
import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import Image

from rostest_support.common import Collected, NodeLog, Process, nightly, run, until
from rostest_support.robotont import RADIUS, RobotontCase, place, stands, used

FIRST_ODOMETRY = 1.0  # [s] from the start of the process, on a machine that has nothing else to do
ATTEMPTS = 3  # the best one counts
WORLD = '''<sdf version="1.6"><world name="w">
<model name="crate"><static>1</static><pose>1.5 0 0.5 0 0 0</pose><link name="l"><collision name="c">
<geometry><box><size>1 1 1</size></box></geometry></collision></link></model>
<model name="tree"><link name="l"><visual name="v"><geometry><mesh><uri>model://oak.dae</uri></mesh></geometry></visual>
</link></model></world></sdf>'''


class StartupTest(RobotontCase):

    def world_file(self, text, suffix):
        file = tempfile.NamedTemporaryFile('w', suffix=suffix)
        self.addCleanup(file.close)
        file.write(text)
        file.flush()
        return file.name

    @nightly
    def test_robotont_refuses_what_cannot_be(self):
        """A start in a wall, bad worlds and bad parameters end the node with file, key and allowed values."""
        bad = self.world_file('boxes: [{name: a, x: 0, y: 0, yaw: 0, length: 0, width: 1, height: 1}]', '.yaml')
        starts = [
            (('_world:=minimaze', '_x:=1.0'),
             'parameters /robotont_gazebo/x, ~y: the robot cannot be at x=1, y=0: wall6'),
            ((f'_world:={bad}',), f'parameter /robotont_gazebo/world: {bad}: a: length is 0; it must be above 0'),
            (('_world:=nowhere',), "parameter /robotont_gazebo/world: there is no world 'nowhere'"),
            (('_model:=turtlebot',), 'one of robotont_gazebo_nuc, robotont_gazebo_lidar, robotont_gazebo_basic'),
            (('_watchdog:=0',), 'a number from 0.05 to 3600, or never s'),
            (('_max_speed:=-1',), 'a number from 0.01 to 10, or none m/s'),
        ]
        processes = [(self.start(f'__name:=robot{number}', f'__ns:=space{number}', *arguments), said)
                     for number, (arguments, said) in enumerate(starts)]
        for number, (process, said) in enumerate(processes):
            said = said.replace('/robotont_gazebo/', f'/space{number}/robot{number}/')
            self.assertIn(said, self.ended(process, 2))

    def test_robotont_reads_a_gazebo_world(self):
        """A box of a .world file stops the robot; the mesh that cannot be read is named."""
        process = self.start(f'_world:={self.world_file(WORLD, ".world")}')
        process.wait_for_output(r'\[WARN\].*tree/l: <mesh> model://oak.dae is left out')
        odometry = self.collected('odom', Odometry)
        self.drive_until(lambda: abs(place(odometry.messages[-1])[0] - (1.0 - RADIUS)) < 1e-6, 'the crate', 2.0)

    @nightly
    def test_robotont_second_one_is_told_and_the_first_drives_on(self):
        """Two robots in one namespace."""
        first = self.start()
        odometry = self.collected('odom', Odometry)
        for arguments, said in (((), '/robotont_gazebo has this name already'),
                                (('__name:=other',), '/robotont_gazebo publishes /odom already')):
            self.assertIn(said, self.ended(self.start(*arguments), 1))
        self.drive_until(lambda: place(odometry.messages[-1])[0] > 0.1, 'a robot that drives', 0.5)
        self.start('__ns:=robot2', '_frame_prefix:=robot2/')
        self.space = '/robot2/'
        self.assertEqual('robot2/odom', self.message('odom', Odometry).header.frame_id)
        self.assertTrue(first.runs(), first.output())

    @nightly
    def test_robotont_takes_the_place_of_one_that_was_killed(self):
        """The registrations of a killed simulator do not prevent the next start."""
        first = self.start()
        self.message('odom', Odometry)
        first.process.kill()
        first.process.wait()
        self.start()
        odometry = self.collected('odom', Odometry)
        self.drive_until(lambda: place(odometry.messages[-1])[0] > 0.1, 'a robot that drives', 0.5)

    @nightly
    def test_robotont_starts_where_another_node_has_the_port_of_one_that_has_gone(self):
        """The master knows /robotont_gazebo and /robotont_camera at the addresses of a node with another name."""
        other = self.start('__name:=other', '__ns:=elsewhere')
        master = rosgraph.Master(rospy.get_name())
        until(lambda: '/elsewhere/other' in rosnode.get_node_names(), 'the other node')
        uri, service = master.lookupNode('/elsewhere/other'), master.lookupService('/elsewhere/other/get_loggers')
        for name, topic in (('/robotont_gazebo', '/odom'), ('/robotont_camera', '/camera/color/image_raw')):
            rosgraph.Master(name).registerPublisher(topic, '*', uri)
            rosgraph.Master(name).registerService(f'{name}/get_loggers', service, uri)
        self.start()
        self.message('odom', Odometry)
        camera = Process(roslib.packages.find_node('robotont_gazebo', 'robotont_camera')[0])
        self.addCleanup(camera.stop)
        self.message('camera/color/image_raw', Image)
        self.assertTrue(other.runs(), other.output())

    def test_robotont_starts_within_a_second(self):
        """From the start of the process to the first odometry."""
        odometry = Collected('/odom', Odometry)
        times = []
        while len(times) < ATTEMPTS and min(times, default=FIRST_ODOMETRY) >= FIRST_ODOMETRY:
            begin, known = time.monotonic(), len(odometry.messages)
            process = self.start()
            until(lambda known=known: len(odometry.messages) > known, 'the first odometry')
            # on a loaded machine it waits for its turn, which is not its fault
            times.append(min(time.monotonic() - begin, used(process.process.pid)))
            process.stop()
        self.assertLess(min(times), FIRST_ODOMETRY, times)

    @nightly
    def test_robotont_stops_where_time_jumps_back(self):
        """Another node publishes /clock and jumps back."""
        rospy.set_param('/use_sim_time', True)
        self.addCleanup(rospy.delete_param, '/use_sim_time')
        clock = rospy.Publisher('/clock', Clock, queue_size=10, latch=True)
        clock.publish(rospy.Time(100))
        self.start('_clock:=false', '_watchdog:=never')
        odometry = self.collected('odom', Odometry)
        log = NodeLog('/robotont_gazebo')
        self.driver()(0.2)
        odometry.next(lambda message: not stands(message), 'a robot that moves')
        self.assertEqual(rospy.Time(100), odometry.messages[-1].header.stamp)
        clock.publish(rospy.Time(50))
        log.wait(Log.WARN, r'Time jumped back by 50.000 s, from 100.000: the robot stops and waits for a new command\.')
        odometry.next(lambda message: stands(message) and message.header.stamp == rospy.Time(50), 'a robot that stands')
        self.driver()(0.2)
        odometry.next(lambda message: not stands(message), 'a robot that moves again')
        self.assertEqual(1, len(log.texts(Log.WARN)))


if __name__ == '__main__':
    run(StartupTest)
