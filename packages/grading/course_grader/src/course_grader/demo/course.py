"""The turtle steps of the demo: each plays a step of the course on a DemoHarness and measures the result.

A step starts a program of the course, or types its command, and measures poses, colours and commands of the turtle
only: ``play(harness)`` returns the Measurements.
"""
import contextlib
import math
import re
import time
from typing import NamedTuple

import rosservice
from geometry_msgs.msg import Twist
from turtlesim.srv import TeleportAbsolute, TeleportRelative

from course_grader.demo.core import track_metrics
from course_grader.demo.harness import CENTRE, EXACT, STEP_TIMEOUT, DemoError, Recorder
from turtle_robotont.driving import accuracy
from turtle_robotont.driving.control import Goal
from turtle_robotont.driving.shapes import Point

CIRCLE_RATE = 8.0  # simulated seconds per wall-clock second: a round of half a minute
CIRCLE_TIMEOUT = 120.0  # [s] for that round, also in a turtlesim that cannot run faster
POSES = 5  # that a subscriber must print at least
STOP_TOLERANCE = 0.02  # [m] of stopping at x
CORNER_TOLERANCE = 0.05  # [m] of driving
HEADING_TOLERANCE = 0.05  # [rad] of driving
PRINTED = 1e-6  # [m] of the last digit that pose_subscriber prints
BLUE, BLACK = (0, 0, 255), (0, 0, 0)
SIM_SERVICES = {'/clear', '/kill', '/reset', '/spawn', '/turtle1/set_pen', '/turtle1/teleport_absolute',
                '/turtle1/teleport_relative', '/turtlesim/get_loggers', '/turtlesim/set_logger_level'}


class Measurement(NamedTuple):
    """A measured value in words, and whether it is correct."""

    text: str
    good: bool


def near(what, value, wanted, tolerance, unit):
    """Return the Measurement of a value that should be close to ``wanted``."""
    return Measurement(f'{what} {value:.3f} {unit} (expected {wanted:.3f}, tolerance {tolerance:g})',
                       abs(value - wanted) <= tolerance)


def at_most(what, value, limit, unit):
    """Return the Measurement of an error that should not exceed ``limit``."""
    return Measurement(f'{what} {value:.3f} {unit} (at most {limit:g})', value <= limit)


def no_teleport(track):
    """Return the Measurement that the turtle was never teleported."""
    count = len(track_metrics.jumps(track))
    return Measurement('driven, not teleported' if count == 0 else f'teleported {count} times instead of driving',
                       count == 0)


def ended_by_itself(process, timeout):
    """Wait until a node ends; return the Measurement that it ended without an error."""
    code = process.wait(timeout)
    return Measurement('ended without an error' if code == 0 else f'ended with exit code {code}: {process.last_line()}',
                       code == 0)


def first_publisher(harness):
    commands = Recorder('turtle1/cmd_vel', Twist, lambda _: time.monotonic())
    node = harness.rosrun('velocity_publisher.py')
    harness.until(lambda: track_metrics.path_length(harness.seen.track) > 0.0, 'the turtle does not start to move',
                  STEP_TIMEOUT, node)
    harness.set_rate(CIRCLE_RATE)
    harness.until(lambda: track_metrics.turned(harness.seen.track) > math.tau, 'the turtle does not close the circle',
                  CIRCLE_TIMEOUT, node)
    commands.end()
    times, speed = commands.entries, track_metrics.top_speed(harness.seen.track)
    harness.set_rate(1.0)
    node.interrupt()
    node.wait(STEP_TIMEOUT)
    harness.until_rest()
    track = harness.seen.track
    return [near('rate of the commands', track_metrics.rate(times), 10.0, 1.0, 'Hz'),
            near('speed of the turtle', speed, 0.5, 1e-3, 'm/s'),
            near('curvature of the circle', track_metrics.curvature(track), 0.2 / 0.5, 1e-2, '1/m'),
            Measurement('stopped after Ctrl-C', track_metrics.stands_still(track))]


def pose_subscriber(harness):
    node = harness.rosrun('pose_subscriber.py')
    harness.until(lambda: 'Turtle pose' in node.output(), 'the node prints no pose', STEP_TIMEOUT, node)
    harness.call('turtle1/teleport_absolute', TeleportAbsolute, 2.5, 7.25, 0.5)
    with contextlib.suppress(DemoError):  # the printed poses are measured below
        harness.until(lambda: node.output().count('x:2.5') > POSES, 'the node does not print the new pose',
                      STEP_TIMEOUT, node)
    printed = re.findall(r'Turtle pose: x:(-?[0-9.]+), y:(-?[0-9.]+)', node.output())
    x, y = map(float, printed[-1])
    pose = harness.seen.track[-1]
    return [Measurement(f'{len(printed)} poses printed', len(printed) > POSES),
            at_most(f'the last one, x {x:.6f} m, y {y:.6f} m, differs from the pose by',
                    math.hypot(x - pose.x, y - pose.y), PRINTED, 'm'),
            near('the turtle was teleported to x =', pose.x, 2.5, EXACT, 'm')]


def stop_at_x(harness):
    ended = ended_by_itself(harness.rosrun('stop_at_x.py'), STEP_TIMEOUT)
    harness.until_rest()
    track = harness.seen.track
    return [ended, Measurement('stands', track_metrics.stands_still(track)), no_teleport(track),
            near('stopped at x =', track[-1].x, 10.0, STOP_TOLERANCE, 'm'),
            near('highest speed', track_metrics.top_speed(track), 1.0, EXACT, 'm/s')]


def square_by_topics(harness):
    end = CENTRE + 2.0
    return _shape(harness, (), [(end, CENTRE), (end, end), (CENTRE, end), (CENTRE, CENTRE)])


def triangle_by_topics(harness):
    arguments = ('_shape:=triangle', '_size:=1.5', '_speed:=3')
    return _shape(harness, arguments, [(CENTRE + 1.5, CENTRE), (CENTRE + 0.75, CENTRE + 0.75 * math.sqrt(3.0)),
                                     (CENTRE, CENTRE)])


def _shape(harness, arguments, corners):
    ended = ended_by_itself(harness.rosrun('drive_shape.py', *arguments), STEP_TIMEOUT)
    harness.until_rest()
    track, corners = harness.seen.track, [Point(*corner) for corner in corners]
    return [ended, no_teleport(track),
            at_most(f'{len(corners)} corners, largest error', max(accuracy.corner_misses(track, corners)),
                    CORNER_TOLERANCE, 'm'),
            at_most('largest distance from the straight sides',
                    track_metrics.path_deviation(track, [corners[-1], *corners]), CORNER_TOLERANCE, 'm'),
            at_most('gap at the end', track_metrics.closing_error(track), CORNER_TOLERANCE, 'm')]


def services_and_pen(harness):
    missing = SIM_SERVICES - set(rosservice.get_service_list())
    ended = ended_by_itself(harness.rosrun('set_pen.py', '_r:=0', '_g:=0', '_b:=255', '_width:=5'), STEP_TIMEOUT)
    harness.call('turtle1/teleport_relative', TeleportRelative, 2.0, 0.0)
    before = len(harness.seen.colours)
    harness.until(lambda: len(harness.seen.colours) > before + 5, 'the colour sensor publishes nothing', STEP_TIMEOUT)
    colour = harness.seen.colours[-1]
    return [Measurement(f'missing services: {", ".join(sorted(missing))}' if missing else
                        f'all {len(SIM_SERVICES)} services of turtlesim are there', not missing), ended,
            Measurement(f'the path under the turtle has the colour {colour} (expected {BLUE})', colour == BLUE)]


def goto_pose(harness):
    server = harness.rosrun('goto_pose_server.py')
    harness.until(lambda: 'Ready' in server.output(), 'the service does not start', STEP_TIMEOUT, server)
    harness.typed('rosservice', 'call', '/turtle1/gotoPose', '1.5', '2.5', '3.14')
    distance, heading = track_metrics.goal_error(harness.seen.track, Goal(1.5, 2.5, 3.14))
    harness.until_rest()
    track = harness.seen.track
    return [at_most('distance to the goal when the service answers', distance, CORNER_TOLERANCE, 'm'),
            at_most('heading error', heading, HEADING_TOLERANCE, 'rad'),
            no_teleport(track), Measurement('stands', track_metrics.stands_still(track))]


def square_by_service(harness):
    corners = [(8.0, CENTRE), (8.0, 8.0), (CENTRE, 8.0), (CENTRE, CENTRE)]
    for (x, y), theta in zip(corners, ('0.0', '1.5708', '3.1416', '4.7124')):
        harness.typed('rosservice', 'call', '/turtle1/teleport_absolute', f'{x:.6f}', f'{y:.6f}', theta)
    harness.until_rest()
    track = harness.seen.track
    return [Measurement(f'{len(track_metrics.jumps(track))} teleports (expected 4)',
                        len(track_metrics.jumps(track)) == 4),
            at_most('largest error of a corner', max(accuracy.corner_misses(track, [Point(*c) for c in corners])),
                    EXACT, 'm'),
            at_most('gap at the end', track_metrics.closing_error(track), EXACT, 'm')]


def black_tour(harness):
    ended = ended_by_itself(harness.rosrun('teleport_tour.py', '_pause:=0.25'), STEP_TIMEOUT)
    harness.until_rest()
    track, colours = harness.seen.track, harness.seen.colours
    places = [Point(2.0, 2.0), Point(9.0, 2.0), Point(9.0, 9.0), Point(2.0, 9.0)]
    on_path = set(colours[colours.index(BLACK):] if BLACK in colours else colours)
    return [ended, Measurement(f'{len(track_metrics.jumps(track))} positions reached by teleport (expected 4)',
                               len(track_metrics.jumps(track)) == 4),
            at_most('largest error of a position', max(accuracy.corner_misses(track, places)), EXACT, 'm'),
            Measurement(f'the path under the turtle has the colours {sorted(on_path)} (expected {BLACK})',
                        on_path == {BLACK})]


PLAYS = (first_publisher, pose_subscriber, stop_at_x, square_by_topics, triangle_by_topics, services_and_pen,
         square_by_service, goto_pose, black_tour)
