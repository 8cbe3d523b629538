"""What a node of navigation is measured with (see probing.py): drives that are played to it.

``/clock`` belongs to this probe: after each message it waits until all threads of the node sleep, so a drive is the
same however fast the machine is. A timer of roscpp that wakes up in the meantime hardly ever counts as work.
"""
import math
import time
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
import tf2_ros
from nav_msgs.msg import Odometry
from nav_msgs.srv import GetMap, GetMapResponse
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from kinematic_core.timing.idle_threads import ProcessThreads
from kinematic_core.worlds import rays
from kinematic_core.worlds.frames import LIDAR_Z, frames
from navigation_core.maps.grid_map import OCCUPIED, UNKNOWN, GridMap
from navigation_core.maps.scores import scores, true_map
from navigation_core.ros import grids
from navigation_core.ros.poses import from_pose, of_transform, to_transform
from probing import COME_UP, Silent, await_true, say
from sim_ros import robotont_messages
from suite_navigation import NOISES, carried_log, error, moments
from unit_support import maze_drive
from unit_support.goals import RESOLUTION
from unit_support.maze_drive import CAMERA, CAMERA_FARTHEST, CAMERA_NEAREST, INCREMENT, MOUNT, START

MAP_SEED, LOCALISATION_SEED = 1, 2
BEGIN = 10.0  # [s] of /clock at the start of a drive
TICKS = 2  # of /clock from scan to scan, for the node's timers
CALM, POLL = 2, 0.002  # checks in a row, [s] between them
BUSY = 60.0  # [s] a node may work on a scan
NAMES = frames('')


class Player:
    """Plays the Moments of a drive to one node."""

    def __init__(self, camera=False):
        rospy.set_param('/use_sim_time', True)
        self._camera = camera
        self.odometry_in_map = None
        # Without queue_size, publish() returns once the message is sent
        self._clock, self._transforms = rospy.Publisher('/clock', Clock), rospy.Publisher('/tf', TFMessage)
        self._odometry, self._scans = rospy.Publisher('odom', Odometry), rospy.Publisher('scan', LaserScan)
        self._mount = tf2_ros.StaticTransformBroadcaster()
        mount = to_transform(MOUNT, NAMES.footprint, NAMES.lidar, rospy.Time(BEGIN))
        mount.transform.translation.z = LIDAR_Z
        self._mount.sendTransform(mount)
        rospy.Subscriber('/tf', TFMessage, self._on_transforms, tcp_nodelay=True)

    def _on_transforms(self, message):
        for each in message.transforms:
            if (each.header.frame_id, each.child_frame_id) == ('map', NAMES.odom):
                self.odometry_in_map = of_transform(each.transform)

    def join(self, name):
        """Wait for the node ``name``."""
        await_true(self._scans.get_num_connections, COME_UP, f'a subscriber of {self._scans.resolved_name}')
        await_true(self._clock.get_num_connections, COME_UP, 'a subscriber of /clock')
        uri = rosgraph.Master(rospy.get_name()).lookupNode(name)
        self._node = ProcessThreads(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2])
        self._settle()

    def _settle(self):
        """Wait until the node sleeps."""
        calm, deadline = 0, time.monotonic() + BUSY
        while calm < CALM:
            if time.monotonic() > deadline:
                raise Silent(f'the node was busy for {BUSY:g} s')
            time.sleep(POLL)
            calm = calm + 1 if self._node.sleeps() else 0

    def play(self, log, events=()):
        """Return the error [m] of the pose at each Moment, None before the first; ``events``: {index: function}."""
        errors = []
        for index, moment in enumerate(log):
            if index in events:
                events[index]()
                self._settle()
            self._send(moment)
            self._settle()
            until = log[index + 1].time if index + 1 < len(log) else moment.time + 1.0
            for tick in range(1, TICKS + 1):
                self._tick(moment.time + (until - moment.time) * tick / TICKS)
            found = self.odometry_in_map and self.odometry_in_map.then(moment.odometry)
            errors.append(found and error(found, moment.truth))
        return errors

    def _tick(self, seconds):
        self._clock.publish(rospy.Time.from_sec(BEGIN + seconds))
        self._settle()

    def _send(self, moment):
        """Publish odometry, its transform and a scan."""
        stamp = rospy.Time.from_sec(BEGIN + moment.time)
        self._clock.publish(stamp)
        self._transforms.publish([to_transform(moment.odometry, NAMES.odom, NAMES.footprint, stamp)])
        odometry = Odometry(child_frame_id=NAMES.footprint)
        odometry.header.stamp, odometry.header.frame_id = stamp, NAMES.odom
        odometry.pose.pose = from_pose(moment.odometry)
        self._odometry.publish(odometry)
        scan = robotont_messages.laser_scan(stamp, NAMES.lidar, rays, moment.ranges)
        if self._camera:
            scan.angle_min += CAMERA.start * INCREMENT
            scan.angle_max = scan.angle_min + (CAMERA.stop - CAMERA.start - 1) * INCREMENT
            scan.range_min, scan.range_max = CAMERA_NEAREST, CAMERA_FARTHEST
            scan.ranges = [each if CAMERA_NEAREST <= each < CAMERA_FARTHEST else math.inf
                           for each in scan.ranges[CAMERA]]
            scan.intensities = []
        self._scans.publish(scan)


def simulated(task):
    """Decorate a task that uses /clock: later nodes use the wall clock again."""
    def run(**arguments):
        try:
            task(**arguments)
        finally:
            rospy.set_param('/use_sim_time', False)
    return run


@simulated
def map_drive(drive):
    """Play a drive to slam_gmapping; say what its map and poses are like."""
    camera, maps = drive == 'camera', []
    log = moments(*NOISES['good' if camera else drive], MAP_SEED)
    player = Player(camera)
    rospy.Subscriber('map', grids.Grid, maps.append, buff_size=2 ** 26)
    say(ready=True)
    player.join('slam_gmapping')
    say(begun=True)
    errors = player.play(log)
    await_true(lambda: maps, COME_UP, 'a map')
    found = scores(grids.from_message(maps[-1]), maze_drive.walls(), START[:2])
    say(errors=errors, iou=found.iou, right=found.right, found=found.found)


def true_grid():
    """Return the true map, which favours no mapper's offset; around the walls, all is unknown."""
    grid = true_map(maze_drive.walls(), RESOLUTION)
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    inside = np.s_[rows.min():rows.max() + 1, columns.min():columns.max() + 1]
    cells = np.full_like(grid.cells, UNKNOWN)
    cells[inside] = grid.cells[inside]
    return GridMap(cells, grid.resolution, grid.origin)


def _localise(log, events=()):
    """Play a drive to amcl; return the errors [m]."""
    first, deviation = log[0].truth, 0.2
    for name, value in (('x', first.x), ('y', first.y), ('a', first.yaw)):
        rospy.set_param(f'amcl/initial_pose_{name}', value)
        rospy.set_param(f'amcl/initial_cov_{name}{name}', deviation ** 2)
    rospy.set_param('amcl/odom_model_type', 'omni-corrected')
    rospy.set_param('amcl/max_particles', 500)
    player, asked, grid = Player(), [], grids.as_lists(grids.to_message(true_grid(), 'map'))
    rospy.Service('static_map', GetMap, lambda _: asked.append(True) or GetMapResponse(grid))
    say(ready=True)
    await_true(lambda: asked, COME_UP, 'a call of static_map')
    player.join('amcl')
    say(begun=True)
    return player.play(log, events)


@simulated
def localise(drive):
    """Play a drive to amcl; say the errors of its poses."""
    say(errors=_localise(moments(*NOISES[drive], LOCALISATION_SEED)))


@simulated
def lose(call):
    """Do so with a robot that is carried away, and call global_localization if ``call``."""
    log, carried = carried_log(moments(*NOISES['good'], LOCALISATION_SEED))
    events = {carried: rospy.ServiceProxy('global_localization', Empty)} if call else ()
    say(errors=_localise(log, events), carried=carried)
