"""The node move_base.

Threading contract: the main thread does one period after the other: it takes goals from the action server, updates the
costmaps, plans, follows and publishes, under ``_lock``. Services take the same lock. Callbacks of topics only store.
"""
from __future__ import annotations

import math
import threading
from types import SimpleNamespace
from typing import Any

import actionlib
import numpy as np
import rospy
import tf2_ros
from dynamic_reconfigure.server import Server
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionGoal, MoveBaseFeedback, MoveBaseGoal, MoveBaseResult
from nav_msgs.msg import Odometry, Path
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse

from move_base import settings
from move_base.conversions import goal_problem, path_message, pose_of, stamped_pose
from move_base.costmaps import CostmapNode
from move_base.settings import PARAMETERS
from navigation_core.planning import global_planner
from navigation_core.planning.global_planner import Plan
from navigation_core.planning.local_planner import Choice, LocalPlanner, Settings, Velocity
from navigation_core.planning.navigator import Navigator, State
from navigation_core.poses import Array, Pose
from rospy_support import nodes, parameters
from rospy_support.parameters import Number
from rospy_support.rotations import yaw_of
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher

REMINDER = 5.0  # [s] of wall time between two equal warnings
ODOMETRY_LASTS = 0.5  # [s]
STILL = Velocity()


class MoveBase:
    """The node; it is also the World of its Navigator."""

    def __init__(self) -> None:
        """Read all parameters and register everything but the action, which waits for map, transforms and odometry."""
        settings.rename_old()
        self._lock = threading.RLock()
        self._throttle = WallThrottle(REMINDER)
        self._global_planner = settings.OWN['~base_global_planner'].read().rpartition('/')[2]
        self._allow_unknown, self._tolerance = settings.PLANNERS.read('~NavfnROS/allow_unknown',
                                                                      '~NavfnROS/default_tolerance')
        name, limits, odom_topic = settings.planner()
        self._frequency = settings.OWN['~controller_frequency'].read()
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._global = CostmapNode('global_costmap', self._buffer)
        self._local = CostmapNode('local_costmap', self._buffer)
        self._planner = LocalPlanner(limits, self._local.footprint, 1.0 / self._frequency)
        self._navigator = Navigator(self, settings.patience())
        self._odometry: Odometry | None = None
        self._odometry_time: rospy.Time | None = None
        self._pose: Pose | None = None
        self._local_pose: Pose | None = None
        self._driving = self._new_path = False
        self._commands = Publisher('cmd_vel', Twist, queue_size=1)
        self._plan = rospy.Publisher(f'~{self._global_planner}/plan', Path, latch=True, queue_size=1)
        self._global_plan = rospy.Publisher(f'~{name}/global_plan', Path, latch=True, queue_size=1)
        self._local_plan = rospy.Publisher(f'~{name}/local_plan', Path, latch=True, queue_size=1)
        self._current = rospy.Publisher('~current_goal', PoseStamped, latch=True, queue_size=1)
        self._goals = rospy.Publisher('move_base/goal', MoveBaseActionGoal, queue_size=1)
        self._odometer = rospy.Subscriber(odom_topic, Odometry, self._store_odometry, queue_size=1)
        self._server = actionlib.SimpleActionServer('move_base', MoveBaseAction, auto_start=False)
        self._started = False
        rospy.Subscriber('move_base_simple/goal', PoseStamped, self._simple_goal, queue_size=1)
        rospy.Service('~make_plan', GetPlan, self._make_plan)
        rospy.Service('~clear_costmaps', Empty, self._clear_costmaps)
        self._reconfigure = Server(_description(limits), self._reconfigured, f'~{name}')
        rospy.on_shutdown(self._stop)
        parameters.log_effective()

    # ------------------------------------------------------------------------------------------------ the loop

    def run(self) -> None:
        rate = rospy.Rate(self._frequency, reset=True)
        while not rospy.is_shutdown():
            with self._lock:
                self._period(rospy.Time.now())
            rate.sleep()

    def _period(self, now: rospy.Time) -> None:
        problem = self._situation(now)
        if not self._started:
            if problem or not now:
                self._throttle.warn('waiting', 'Not ready for goals: %s', problem or 'no message on /clock yet')
                return
            rospy.loginfo('odom received!')
            self._started = True
            self._server.start()
        self._take_goal(now)
        if self._server.is_active():
            if self._server.is_preempt_requested() and not self._server.is_new_goal_available():
                self._stop()
                self._server.set_preempted(text='The goal was cancelled.')
            elif problem or self._silence(now):
                self._stop()
                self._throttle.warn('stands', 'The robot has stopped: %s', problem or self._silence(now))
            else:
                self._drive(now)

    def _situation(self, now: rospy.Time) -> str:
        """Update poses and costmaps; return what is missing to drive, or ''."""
        self._pose, problem = self._global.pose()
        self._local_pose, local_problem = self._local.pose()
        for costmap, pose in ((self._global, self._pose), (self._local, self._local_pose)):
            if pose is not None:
                costmap.update(now, pose)
        if self._odometry is None:
            odometry = f'no message on {self._odometer.resolved_name}: start the robot or its simulation'
        else:
            past = (now - self._odometry_time).to_sec()
            odometry = f'no message on {self._odometer.resolved_name} for {past:.1f} s' if past > ODOMETRY_LASTS else ''
        missing = self._global.missing() or self._local.missing()
        if self._global.costmap is None and not missing:
            missing = problem or f'the map on {self._global.map_topic} cannot be used'
        return missing or odometry or problem or local_problem

    def _silence(self, now: rospy.Time) -> str:
        return self._local.silence(now) or self._global.silence(now)

    def _take_goal(self, now: rospy.Time) -> None:
        # in lockstep, a goal of this very instant arrives before or after the period by chance: the next one takes it
        if not self._server.is_new_goal_available() or self._server.next_goal.get_goal_id().stamp == now:
            return
        target = self._server.accept_new_goal().target_pose
        self._stop_unless_driving()
        goal, problem = self._in_map(target)
        if goal is None:
            self._stop()
            rospy.logerr('The goal is refused: %s', problem)
            self._server.set_aborted(MoveBaseResult(), f'The goal is refused: {problem}')
            return
        self._current.publish(stamped_pose(goal, self._global.frame, now))
        self._planner.start()
        self._navigator.start(goal, self._pose or goal, now.to_sec())

    def _stop_unless_driving(self) -> None:
        if self._navigator.state not in (State.FOLLOWING, State.PLANNING):
            self._stop()

    def _in_map(self, target: PoseStamped) -> tuple[Pose | None, str]:
        """Return (Pose, '') of a PoseStamped in the frame of the global costmap, or (None, why not)."""
        problem = goal_problem(target.pose)
        frame = target.header.frame_id.lstrip('/')
        if problem or not frame:
            return None, problem or f'it names no frame; set target_pose.header.frame_id = "{self._global.frame}"'
        pose = Pose(target.pose.position.x, target.pose.position.y, yaw_of(target.pose.orientation))
        if frame == self._global.frame:
            return pose, ''
        try:
            stamped = self._buffer.lookup_transform(self._global.frame, frame, rospy.Time())
        except tf2_ros.TransformException as error:
            return None, f'its frame {frame} cannot be transformed to {self._global.frame}: {error}'
        return pose_of(stamped.transform).then(pose), ''

    def _drive(self, now: rospy.Time) -> None:
        assert self._pose is not None
        navigator = self._navigator
        step = navigator.step(self._pose, now.to_sec())
        if step.note:
            log = rospy.logdebug if step.note == 'a new path' else rospy.logwarn
            if navigator.state == State.RECOVERING or self._throttle.due(step.note):
                log('%s%s', step.note[0].upper(), step.note[1:])
        self._command(step.velocity)
        if step.choice is not None:
            self._local_plan.publish(path_message(step.choice.poses, self._local.frame, now))
        self._server.publish_feedback(MoveBaseFeedback(stamped_pose(self._pose, self._global.frame, now)))
        if navigator.state == State.REACHED:
            self._stop()
            self._server.set_succeeded(MoveBaseResult(), 'Goal reached.')
        elif navigator.state == State.FAILED:
            self._stop()
            rospy.logerr('The goal is given up: %s', navigator.problem)
            self._server.set_aborted(MoveBaseResult(), f'The goal is given up: {navigator.problem}')

    def _command(self, velocity: Velocity) -> None:
        self._driving = True
        self._commands.publish(Twist(Vector3(velocity.x, velocity.y, 0.0), Vector3(0.0, 0.0, velocity.theta)))

    def _stop(self) -> None:
        """Stop the robot; only once, so that others can drive it afterwards."""
        if self._driving:
            self._command(STILL)
            self._driving = False

    # ------------------------------------------------------------------------------------- the Navigator's World

    def plan(self, goal: Pose) -> Plan:
        """Plan from the robot to ``goal``, and publish the path."""
        assert self._pose is not None
        plan = self._plan_between(self._pose, goal, self._tolerance)
        if plan.path is not None:
            now = rospy.Time.now()
            self._plan.publish(path_message(plan.path, self._global.frame, now, goal.yaw))
            self._new_path = True
        return plan

    def _plan_between(self, start: Pose, goal: Pose, tolerance: float) -> Plan:
        assert self._global.costmap is not None
        return global_planner.plan(self._global.costmap, start[:2], goal[:2], tolerance, self._allow_unknown)

    def is_hopeless(self, goal: Pose) -> bool:
        """Return whether the goal is outside of the map, or in one of its walls."""
        costmap = self._global.costmap
        assert costmap is not None
        plan = global_planner.plan(costmap.without_seen(), goal[:2], goal[:2], self._tolerance, True)
        return plan.path is None

    def follow(self, path: Array, heading: float, new: bool) -> tuple[Choice, bool]:
        """Return the Choice for the next period, and whether the goal was reached."""
        if new:
            self._planner.start()
        assert self._pose is not None and self._local_pose is not None and self._local.costmap is not None
        to_local = self._local_pose.then(self._pose.inverse())
        points = np.stack(to_local.to_outer(path[:, 0], path[:, 1]), axis=1)
        if self._new_path:
            self._new_path = False
            self._global_plan.publish(path_message(points, self._local.frame, rospy.Time.now()))
        choice = self._planner.choose(self._local.costmap, self._local_pose, self._velocity(), points,
                                      heading + to_local.yaw)
        return choice, self._planner.reached

    def turn(self, angle: float) -> Choice:
        """Return the Choice for turning on the spot by ``angle`` [rad]."""
        assert self._local.costmap is not None and self._local_pose is not None
        return self._planner.turn(self._local.costmap, self._local_pose, self._velocity(), angle)

    def clear(self, distance: float) -> None:
        """Forget obstacles farther away than ``distance`` [m] in both costmaps."""
        assert self._pose is not None and self._local_pose is not None
        self._global.clear(self._pose, distance)
        self._local.clear(self._local_pose, distance)

    def _velocity(self) -> Velocity:
        assert self._odometry is not None
        twist = self._odometry.twist.twist
        velocity = Velocity(twist.linear.x, twist.linear.y, twist.angular.z)
        return velocity if all(map(math.isfinite, velocity)) else STILL

    # -------------------------------------------------------------------------------------------- topics, services

    def _store_odometry(self, message: Odometry) -> None:
        self._odometry, self._odometry_time = message, rospy.Time.now()

    def _simple_goal(self, message: PoseStamped) -> None:
        if not self._started:
            rospy.logwarn('A goal on move_base_simple/goal is ignored: move_base is not ready')
            return
        goal = MoveBaseActionGoal(goal=MoveBaseGoal(message))
        goal.header.stamp = rospy.Time.now()
        self._goals.publish(goal)

    def _make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        with self._lock:
            if self._global.costmap is None:
                raise rospy.ServiceException(self._situation(rospy.Time.now()) or 'there is no map yet')
            goal, problem = self._in_map(request.goal)
            if goal is None:
                raise rospy.ServiceException(f'goal: {problem}')
            start, problem = self._pose, 'the pose of the robot is not known'
            if request.start.header.frame_id:
                start, problem = self._in_map(request.start)
            if start is None:
                raise rospy.ServiceException(f'start: {problem}')
            plan = self._plan_between(start, goal, request.tolerance)
        if plan.path is None:
            rospy.logwarn('make_plan: %s', plan.problem)
            return GetPlanResponse(Path())
        return GetPlanResponse(path_message(plan.path, self._global.frame, rospy.Time.now(), goal.yaw))

    def _clear_costmaps(self, _: EmptyRequest) -> EmptyResponse:
        with self._lock:
            for costmap in (self._global, self._local):
                costmap.clear(Pose(), -1.0)
        return EmptyResponse()

    def _reconfigured(self, config: Any, _: int) -> Any:
        for name in settings.RECONFIGURABLE:
            setattr(self._planner.settings, name, config[name])
        return config


def _description(limits: Settings) -> SimpleNamespace:
    """Return what a dynamic_reconfigure Server needs to know about the parameters that may change."""
    declared = {name: number for name in settings.RECONFIGURABLE
                for number in [settings.PLANNERS[f'~TrajectoryPlannerROS/{name}']] if isinstance(number, Number)}
    group = {'name': 'Default', 'type': '', 'id': 0, 'parent': 0, 'state': True, 'groups': [], 'parameters': [
        {'name': name, 'type': 'double', 'level': 0, 'description': f'{name} [{number.unit}]', 'edit_method': ''}
        for name, number in declared.items()]}
    return SimpleNamespace(config_description=group, defaults={name: float(getattr(limits, name)) for name in declared},
                           min={name: number.minimum for name, number in declared.items()},
                           max={name: number.maximum for name, number in declared.items()})


def main() -> None:
    nodes.init_node('move_base', PARAMETERS)
    MoveBase().run()
