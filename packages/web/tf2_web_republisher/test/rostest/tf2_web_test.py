#!/usr/bin/env python3
"""tf2_web_republisher from outside: transforms as a topic and as feedback of an action."""
import actionlib
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionGoal
from tf2_web_republisher.srv import RepublishTFs

from rostest_support.common import DEADLINE, Collected, SimulatorCase, proxy, run, until

FAST = 50.0  # [Hz]
THRESHOLD = 0.1  # [m, rad]


class TfWebTest(SimulatorCase):

    def setUp(self):
        """Publish a transform; no simulator is needed."""
        self.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.move(0.0)

    def move(self, x):
        """Publish where the robot is."""
        transform = TransformStamped(child_frame_id='robot')
        transform.header.frame_id = 'map'
        transform.transform.translation.x, transform.transform.rotation.w = x, 1.0
        self.broadcaster.sendTransform(transform)

    def test_topic_has_changes_and_ends(self):
        topic = proxy('/republish_tfs', RepublishTFs)(['/robot', 'nowhere'], '/map', THRESHOLD, THRESHOLD, FAST,
                                                      rospy.Duration(1.0)).topic_name
        received = Collected(topic, TFArray)
        first = received.some(0, 1)[0].transforms
        found = [(one.header.frame_id, one.child_frame_id, one.transform.translation.x) for one in first]
        self.assertEqual([('map', 'robot', 0.0)], found)
        for x in (0.05, 0.5):
            self.move(x)
        until(lambda: received.messages[-1].transforms[0].transform.translation.x == 0.5, 'the change')
        self.assertNotIn(0.05, [message.transforms[0].transform.translation.x for message in received.messages])
        received.subscriber.unregister()
        until(lambda: topic not in dict(rospy.get_published_topics()), 'the end of the topic')

    def test_action_gives_feedback_until_it_is_cancelled(self):
        client = actionlib.SimpleActionClient('/tf2_web_republisher', TFSubscriptionAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(DEADLINE)))
        frames = []
        client.send_goal(TFSubscriptionGoal(['robot'], 'map', 0.0, 0.0, FAST), feedback_cb=frames.append)
        until(lambda: len(frames) > 3, 'the feedback')
        client.cancel_goal()
        self.assertTrue(client.wait_for_result(rospy.Duration(DEADLINE)))
        self.assertEqual(actionlib.GoalStatus.PREEMPTED, client.get_state())

    def test_wrong_request_is_refused(self):
        with self.assertRaisesRegex(rospy.ServiceException, 'rate is 0 Hz; it must be from 0.01 to 1000'):
            proxy('/republish_tfs', RepublishTFs)(['robot'], 'map', 0.0, 0.0, 0.0, rospy.Duration(1.0))


if __name__ == '__main__':
    run(TfWebTest)
