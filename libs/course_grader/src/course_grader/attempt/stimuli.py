"""What the grader does while a student's node is observed: drives the turtle, calls services, shows markers.

They follow simulated time. What they do is drawn before anything begins (rules/random_stimuli.py).

Threads: each stimulus has its own, which only appends to lists.
"""
import threading

import rosgraph
import roslib.message
import rospy
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers

from course_grader.rules import random_stimuli
from course_grader.rules.observation import Call, ShownMarkers

DRIVE_RATE = 10.0  # [Hz]
TRACKER_RATE = 8.0  # [Hz] of messages, as of ar_track_alvar by default (max_frequency)
ANSWER_TIME = 5.0  # [s] in which a service must answer
POLL = 0.05  # [s]


class Stimuli:
    """The stimuli of an exercise, counted from the simulated time ``zero`` [s]."""

    def __init__(self, exercise, seed, zero, observed, steering):
        """``observed``: the Observed that takes what was done; ``steering``: forked.Steering of the turtle."""
        self._zero, self._observed, self._steering = zero, observed, steering
        self._threads = [threading.Thread(target=self._do, args=(what, values, drawn), name=what, daemon=True)
                         for (what, values), drawn in zip(exercise.stimuli, random_stimuli.stimuli(exercise, seed))]

    def start(self):
        """Start all of them."""
        for thread in self._threads:
            thread.start()

    def done(self):
        """Return whether all are done."""
        return not any(thread.is_alive() for thread in self._threads)

    def _do(self, what, values, drawn):
        try:
            getattr(self, f'_{what}')(values, drawn)
        except (rospy.ROSException, OSError):  # time stops or jumps, or the simulator has ended: the grading is over
            pass

    def _now(self):
        return rospy.get_time() - self._zero

    def _drive(self, values, velocities):
        rospy.sleep(max(0.0, values['after'] - self._now()))
        rate = rospy.Rate(DRIVE_RATE)
        while self._now() < values['after'] + values['for']:
            leg = int((self._now() - values['after']) / random_stimuli.LEG)
            self._steering.drive(*velocities[min(max(leg, 0), len(velocities) - 1)])
            rate.sleep()

    def _call(self, values, requests):
        rospy.sleep(max(0.0, values['after'] - self._now()))
        service_class = roslib.message.get_service_class(values['type'])
        for request in requests:
            start = self._now()
            while not _offered(values['service']):
                if self._now() > start + ANSWER_TIME:
                    return  # never offered: there is no Call
                rospy.sleep(POLL)
            call = self._ask(values['service'], service_class, request)
            self._observed.calls.append(call._replace(t=call.t + self._observed.start))

    def _ask(self, service, service_class, request):
        """Call a service with a time limit; return the Call."""
        start, answer = self._now(), []

        def ask():
            try:
                rospy.ServiceProxy(service, service_class)(*request)
                answer.append('')
            except (rospy.ServiceException, rospy.ROSException, OSError) as error:
                other = f'{service} is not of the type {service_class._type}: ' if 'md5sum' in str(error) else ''
                answer.append(other + (str(error) or type(error).__name__))
        thread = threading.Thread(target=ask, daemon=True)
        thread.start()
        while thread.is_alive() and self._now() < start + ANSWER_TIME:
            rospy.sleep(POLL)
        trouble = answer[0] if answer else f'{service} did not answer within {ANSWER_TIME:g} s'
        return Call(start, service, request, not trouble, trouble)

    def _markers(self, values, shows):
        publisher = rospy.Publisher(values['topic'], AlvarMarkers, queue_size=10)
        while publisher.get_num_connections() == 0 and self._now() < values['for']:
            rospy.sleep(POLL)
        repeats = max(1, round(TRACKER_RATE / values['rate']))
        rate = rospy.Rate(repeats * values['rate'])
        for markers in shows:
            self._observed.shown.append(ShownMarkers(self._now() + self._observed.start, markers))
            for _ in range(repeats):
                publisher.publish(_message(markers))
                rate.sleep()


def _message(markers):
    """Return AlvarMarkers of {id: (x, y, z)}."""
    message = AlvarMarkers()
    message.header.stamp, message.header.frame_id = rospy.Time.now(), 'camera_link'
    for marker, position in markers.items():
        entry = AlvarMarker(id=marker, confidence=100)
        entry.header = entry.pose.header = message.header
        entry.pose.pose.position.x, entry.pose.pose.position.y, entry.pose.pose.position.z = position
        entry.pose.pose.orientation.w = 1.0
        message.markers.append(entry)
    return message


def _offered(service):
    try:
        return bool(rosgraph.Master(rospy.get_name()).lookupService(service))
    except rosgraph.MasterError:
        return False
