"""The stimuli of a grading: the grader drives the turtle, calls services, sends goals, or publishes sensor data.

Stimuli follow simulated time. Their random values are drawn before the observation (rules/random_stimuli.py).

Threads: each stimulus has its own, which only appends to lists.
"""
import collections
import math
import threading

import actionlib
import rosgraph
import roslib.message
import rospy
from actionlib_msgs.msg import GoalStatus
from actionlib_tutorials.msg import FibonacciAction, FibonacciActionFeedback, FibonacciGoal
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers
from geometry_msgs.msg import Point, Pose, PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import Header

from course_grader.attempt import service_types
from course_grader.rules import random_stimuli
from course_grader.rules.observation import ANGLES, Call, Goal, Sensed, ShownMarkers, computed
from kinematic_core.timing.pacing import BEGIN
from kinematic_core.worlds import world_format
from kinematic_core.worlds.planar import Pose2D
from rospy_support import rotations

DRIVE_RATE = 10.0  # [Hz]
TRACKER_RATE = 8.0  # [Hz] of messages, as of ar_track_alvar by default (max_frequency)
ANSWER_TIME = 5.0  # [s] in which a service must answer
GOAL_TIME, CANCEL_AFTER, CANCEL_TIME = 10.0, 1.0, 2.0  # [s] for a result; until a goal is cancelled; for its end
KNOWN = 0.1  # [s] after a connection, until its publisher sends there, too: the subscriber knows it a little earlier
FEEDBACK_TIME = 1.0  # [s] after a result for feedback that it has overtaken: ROS orders no messages of two topics
LONG_ORDER = 40  # of the goal that is cancelled
POLL = 0.05  # [s]
OF_STEPS = {'distances', 'tracker'}  # stimuli that are told the time with each pose
HELD, HELD_AT = 1, (0.8, 0.0, 0.1)  # the marker that is turned: its id, and its position [m]
ROBOT = 'robotont'  # the vehicle of the simulator
DISTANCES_EVERY, MARKERS_EVERY = 12, 16  # steps of the robot: 10 Hz; 7.5 Hz, about TRACKER_RATE
SPLITS = {  # message types of the distances in three sectors: their field names
    'robotont_laserscan_to_distance/LaserScanSplit': ('{}_min', '{}_mean'),
    'robotont_sensors/LaserScanSplit': ('{}Min', '{}Mean')}


class Stimuli:
    """The stimuli of an exercise, counted from the simulated time ``zero`` [s]."""

    def __init__(self, exercise, seed, zero, observed, link):
        """``observed``: the Observed to which events are added; ``link``: the SimulatorLink."""
        self._zero, self._observed, self._link, self._world = zero, observed, link, exercise.world
        self._time = exercise.time
        self._threads = [threading.Thread(target=self._do, args=(what, values, drawn), name=what, daemon=True)
                         for (what, values), drawn in zip(exercise.stimuli, random_stimuli.stimuli(exercise, seed))]

    def start(self):
        if any(thread.name not in OF_STEPS for thread in self._threads):
            self._link.follow()
        for thread in self._threads:
            thread.start()

    def done(self):
        return not any(thread.is_alive() for thread in self._threads)

    def _do(self, what, values, drawn):
        try:
            if 'after' in values:
                rospy.sleep(max(0.0, values['after'] - self._now()))
            ACTS[what](self, values, drawn)
        except (rospy.ROSException, OSError):  # time has stopped or jumped, or the simulator has ended
            pass

    def _now(self):
        return rospy.get_time() - self._zero

    def _drive(self, values, velocities):
        rate = rospy.Rate(DRIVE_RATE)
        while self._now() < values['after'] + values['for']:
            leg = int((self._now() - values['after']) / random_stimuli.LEG)
            self._link.drive(*velocities[min(max(leg, 0), len(velocities) - 1)])
            rate.sleep()

    def _call(self, values, requests):
        service_class = roslib.message.get_service_class(values['type'])
        requests = [service_types.request(service_class, numbers) for numbers in requests]
        for number, request in enumerate(requests):
            start = self._now()
            while not _offered(values['service']):
                if self._now() > start + ANSWER_TIME:
                    if number:  # else it was never offered: there is no Call
                        self._observed.calls += [Call(start + self._observed.start, values['service'], other, False,
                                                      'then it was not offered any more')
                                                 for other in requests[number:]]
                    return
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

    def _goals(self, values, orders):
        seen = collections.Counter()  # {id of a goal: messages of feedback}; the client drops those after a result
        rospy.Subscriber(f'{values["action"]}/feedback', FibonacciActionFeedback,
                         lambda feedback: seen.update([feedback.status.goal_id.id]))
        client = actionlib.ActionClient(values['action'], FibonacciAction)  # the simple one can miss an early end
        if not client.wait_for_server(rospy.Duration(ANSWER_TIME)):
            return  # never offered: there is no Goal
        rospy.sleep(KNOWN)
        for order, cancelled in (*((order, False) for order in orders), (LONG_ORDER, True)):
            start = self._now()
            goal = client.send_goal(FibonacciGoal(order))
            self._wait_for_result(goal, CANCEL_AFTER if cancelled else GOAL_TIME)
            if cancelled:
                goal.cancel()
                self._wait_for_result(goal, CANCEL_TIME)
            number, end = goal.comm_state_machine.action_goal.goal_id.id, self._now() + FEEDBACK_TIME
            while not cancelled and seen[number] < computed(order) and self._now() < end:
                rospy.sleep(POLL)
            result = goal.get_result()
            self._observed.goals.append(Goal(
                start + self._observed.start, values['action'], order, cancelled,
                GoalStatus.to_string(goal.get_goal_status()), seen[number], tuple(result.sequence) if result else ()))

    def _wait_for_result(self, goal, longest):
        end = self._now() + longest
        while self._now() < end and goal.get_comm_state() != actionlib.CommState.DONE:
            rospy.sleep(POLL)

    def _carry(self, values, poses):
        self._link.carry(*poses[0])
        self._observed.carried.append(self._now() + self._observed.start)

    def _move(self, values, _):
        name, pose = values['panel'], values['to']

        def moved(seconds):
            plan = (self._observed.moved or [(0.0, self._observed.plan)])[-1][1].with_panel(name, *pose)
            self._observed.moved.append((seconds - self._zero + self._observed.start, plan))
        self._link.move(name, *pose, moved)

    def _destinations(self, values, _):
        client = actionlib.ActionClient('/move_base', MoveBaseAction)
        if not client.wait_for_server(rospy.Duration(ANSWER_TIME)):
            return
        for x, y, heading in values['goals']:
            pose = Pose(Point(x, y, 0.0), rotations.to_quaternion(0.0, 0.0, heading))
            goal = client.send_goal(MoveBaseGoal(PoseStamped(Header(stamp=rospy.Time.now(), frame_id='map'), pose)))
            self._wait_for_result(goal, self._time)

    def _heard_publisher(self, values):
        publisher = rospy.Publisher(values['topic'], AlvarMarkers, queue_size=10)
        while publisher.get_num_connections() == 0 and self._now() < values['for']:
            rospy.sleep(POLL)
        return publisher

    def _markers(self, values, shows):
        publisher = self._heard_publisher(values)
        repeats = max(1, round(TRACKER_RATE / values['rate']))
        rate = rospy.Rate(repeats * values['rate'])
        for markers in shows:
            self._observed.shown.append(ShownMarkers(self._now() + self._observed.start, markers))
            for number in range(repeats):
                if number < repeats - 1 or repeats == 1:  # not the last one: a line may come a little later
                    publisher.publish(_message(markers, rospy.Time.now()))
                rate.sleep()

    def _turns(self, values, poses):
        publisher = self._heard_publisher(values)
        rate = rospy.Rate(TRACKER_RATE)
        for pose in poses:
            for what, angle in zip(ANGLES, pose or (math.nan,) * len(ANGLES)):
                self._observed.sensed.append(Sensed(self._now() + self._observed.start, what, angle))
            message = _message({} if pose is None else {HELD: HELD_AT}, rospy.Time.now())
            for marker in message.markers:
                marker.pose.pose.orientation = rotations.to_quaternion(*pose)
            for _ in range(round(random_stimuli.LEG * TRACKER_RATE)):
                message.header.stamp = rospy.Time.now()
                publisher.publish(message)
                rate.sleep()

    def _distances(self, values, _):
        from course_grader.rules import robot_sensors  # the original robotont_gazebo does not have these modules
        self._link.follow()
        kind = self._type_of(values['topic'], values['for'])
        self._link.follow(False)
        message_class = roslib.message.get_message_class(kind)
        publisher = rospy.Publisher(values['topic'], message_class, queue_size=10)
        sensor = robot_sensors.DistanceSensor(self._plan())

        def publish(stamp, pose):
            sectors = sensor.measure(pose)
            self._note(stamp, 'ahead', sectors.center.nearest)
            publisher.publish(_split_message(message_class, SPLITS[kind], stamp, sectors))
        self._sense(values, DISTANCES_EVERY, publish)

    def _type_of(self, topic, longest):
        """Return the type of SPLITS to which a program subscribes; wait for it up to ``longest`` [s]."""
        while self._now() < longest:
            found = dict(rosgraph.Master(rospy.get_name()).getTopicTypes()).get(topic)
            if found:
                return found if found in SPLITS else next(iter(SPLITS))
            rospy.sleep(POLL)
        return next(iter(SPLITS))

    def _tracker(self, values, _):
        from course_grader.rules import robot_sensors
        plan, publisher = self._plan(), rospy.Publisher(values['topic'], AlvarMarkers, queue_size=10)
        camera = robot_sensors.MarkerCamera(plan)

        def publish(stamp, pose):
            seconds = stamp.to_sec() - BEGIN / 1e9
            for x, y, _ in robot_sensors.markers(plan, seconds, pose).values():
                self._note(stamp, 'marker ahead', x)
                self._note(stamp, 'marker left', y)
            publisher.publish(_message(camera.seen(seconds, pose), stamp))
        self._sense(values, MARKERS_EVERY, publish)

    def _plan(self):
        return world_format.parse(self._world)

    def _note(self, stamp, what, value):
        self._observed.sensed.append(Sensed(stamp.to_sec() - self._zero + self._observed.start, what, value))

    def _sense(self, values, every, publish):
        """Call ``publish(stamp, Pose2D)`` in every ``every``-th step of the robot; return when the stimulus is over."""
        over = threading.Event()

        def at_step(steps, pose):
            stamp = self._link.time_after(steps)
            publish(stamp, Pose2D(*pose))
            if stamp.to_sec() - self._zero >= values['for']:
                over.set()
        self._link.watch(ROBOT, at_step, every, True)
        over.wait()


ACTS = {  # what an exercise asks for in a stimulus: how it is done
    'drive': Stimuli._drive, 'call': Stimuli._call, 'goals': Stimuli._goals, 'carry': Stimuli._carry,
    'move': Stimuli._move, 'destinations': Stimuli._destinations, 'markers': Stimuli._markers, 'turns': Stimuli._turns,
    'distances': Stimuli._distances, 'tracker': Stimuli._tracker}


def _split_message(message_class, names, stamp, sectors):
    fields = {pattern.format(side): value for side in ('left', 'center', 'right')
              for pattern, value in zip(names, getattr(sectors, side))}
    message = message_class(**fields)
    if hasattr(message, 'header'):
        message.header.stamp = stamp
    else:
        message.stamp = stamp
    return message


def _message(markers, stamp):
    """Return AlvarMarkers of {id: (x, y, z)}."""
    message = AlvarMarkers()
    message.header.stamp, message.header.frame_id = stamp, 'camera_link'
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
