#!/usr/bin/env python3
"""draw_square: how it begins and ends."""
import roslib.packages
import rospy
from std_srvs.srv import Empty, EmptyResponse

from rostest_support.common import DEADLINE, MIDDLE, Process, SimulatorCase, own_simulator, run, until

DRAW_SQUARE = roslib.packages.find_node('turtlesim', 'draw_square')[0]


class DrawSquareTest(SimulatorCase):

    def start(self, *arguments):
        process = Process(DRAW_SQUARE, *arguments)
        self.addCleanup(process.stop)
        return process

    def test_draw_square_resets_first(self):
        """Reset: one turtle, starting in the middle."""
        self.call('spawn', 2.0, 2.0, 0.0, 'turtle2')
        self.call('turtle1/teleport_absolute', 1.0, 1.0, 1.0)
        poses = self.poses()
        process = self.start()
        poses.next(lambda pose: pose.linear_velocity > 0.0, 'the turtle driving')
        self.assertEqual({'turtle1'}, self.turtles())
        self.assert_pose(poses.messages[-1], MIDDLE, MIDDLE, 0.0, tolerance=1.0)
        self.assertIn(f'x={MIDDLE + 2:.3f}, y={MIDDLE:.3f}', process.output())

    def test_draw_square_waits_for_a_simulator(self):
        """Started before its simulator."""
        process = self.start('__ns:=later')
        process.wait_for_output('Waiting for the service /later/reset')
        with own_simulator('__ns:=later'):
            process.wait_for_output('Corner reached at', 2 * DEADLINE)

    def test_draw_square_resets_again_after_a_failure(self):
        """Reset fails at first."""
        answers = []

        def reset(_):
            answers.append(len(answers) > 0)
            if not answers[-1]:
                raise rospy.ServiceException('not yet')
            return EmptyResponse()

        service = rospy.Service('/failing/reset', Empty, reset)
        self.addCleanup(service.shutdown)
        process = self.start('__ns:=failing')
        until(lambda: answers == [False, True], f'a second call; {answers}')
        process.wait_for_output('/failing/reset failed; calling it again: .*not yet')
        self.assertTrue(process.runs())

    def test_draw_square_refuses_a_side_that_does_not_fit(self):
        """A bad parameter: exit code 2 and a text."""
        process = self.start('_side:=9.0')
        process.wait_for_output('/draw_square/side is 9.0; it must be a number from 0.1 to 5.5 m')
        self.assertEqual(2, process.process.wait(DEADLINE))


if __name__ == '__main__':
    run(DrawSquareTest)
