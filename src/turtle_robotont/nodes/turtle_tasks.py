"""One-shot tasks of the course: stop at x, draw a shape, teleport around.

Each takes a TurtleDriver, returns when it is done, and raises DriveError or InvalidInput if it fails.
"""
import math

import rospy
from turtlesim.srv import SetPen, TeleportAbsolute

from rospy_support.rospy_internals import steady_time
from turtle_robotont.driving import drawing
from turtle_robotont.driving.control import Goal, GoTo, State, require_goal
from turtle_robotont.driving.shapes import distance, point_at_x
from turtle_robotont.nodes.driver import DriveError

SERVICE_TIMEOUT = 10.0  # [s]
TELEPORT_TIMEOUT = 2.0  # [s] until a teleport shows in the pose
TELEPORT_TOLERANCE = 1e-3  # [m]


def stop_at_x(driver, x, limits):
    """Drive until the turtle stands at ``x`` [m]."""
    pose = driver.ready()
    target = point_at_x(pose, x)
    rospy.loginfo('Driving from x = %.3f to x = %.3f m at %.2f m/s', pose.x, x, limits.speed)
    drive = GoTo(pose, Goal(target.x, target.y), limits)
    require_arrived(drive, driver.drive(drive))
    pose = driver.pose()
    rospy.loginfo('Stopped at x = %.4f m, y = %.4f m: error %.4f m', pose.x, pose.y, abs(pose.x - x))


def draw_shape(driver, shape, size, corners, limits, strafe=False):
    """Draw a shape with a turtle or a robot; parameters as in turtle_robotont.driving.drawing.plan."""
    pose = driver.ready()
    plan = drawing.plan(shape, pose, size, corners, limits, driver.vehicle, strafe)
    rospy.loginfo('Drawing: %s, starting at (%.2f, %.2f)', shape, *plan.start)
    result = driver.drive(plan.drive)
    require_arrived(plan.drive, result)
    worst, gap = plan.errors(result.track)
    rospy.loginfo('Drawn in %.1f s: largest error %.3f m, gap at the end %.3f m', result.elapsed, worst, gap)


def teleport_tour(driver, positions, colour, width, pause):
    """Teleport the turtle to each of ``positions`` [m], drawing a path of ``colour`` and ``width`` [px].

    ``pause`` [s] is the time between two teleports.
    """
    goals = [require_goal(point.x, point.y, 0.0) for point in positions]
    before = driver.ready()
    set_pen(f'{driver.turtle}/set_pen', *colour, width, 0)
    for goal in goals:
        theta = math.atan2(goal.y - before.y, goal.x - before.x)
        rospy.loginfo('Goto => x: %.2f y: %.2f theta: %.2f', goal.x, goal.y, theta)
        teleport(driver, goal._replace(theta=theta))
        before = goal
        rospy.sleep(pause)
    rospy.loginfo('Visited all %d positions', len(goals))


def teleport(driver, goal):
    """Teleport the turtle to ``goal`` and wait until its pose shows that."""
    call(f'{driver.turtle}/teleport_absolute', TeleportAbsolute, goal.x, goal.y, goal.theta)
    deadline = steady_time() + TELEPORT_TIMEOUT
    pose = driver.pose()
    while distance(pose, goal) > TELEPORT_TOLERANCE:
        if steady_time() > deadline:
            raise DriveError(f'teleported to ({goal.x:.2f}, {goal.y:.2f}), but the turtle is at ({pose.x:.2f}, '
                             f'{pose.y:.2f}); is another node moving it?')
        pose = driver.pose()


def set_pen(service, r, g, b, width, off):
    """Set a turtle's pen: r, g, b 0..255, width [px], off 0 or 1."""
    call(service, SetPen, r, g, b, width, off)


def call(service, service_type, *request):
    """Call a service, waiting for it up to SERVICE_TIMEOUT; raise DriveError if it is missing or refuses."""
    name = rospy.resolve_name(service)
    try:
        rospy.wait_for_service(service, SERVICE_TIMEOUT)
        return rospy.ServiceProxy(service, service_type)(*request)
    except rospy.ROSInterruptException:
        raise
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise DriveError(f'{name} cannot be called: {error}; is the simulator running? (rosservice list)') from None


def require_arrived(drive, result):
    """Raise DriveError with the drive's reason unless it arrived."""
    if drive.state is not State.ARRIVED:
        raise DriveError(f'did not arrive within {result.elapsed:.1f} s: {drive.reason}')
