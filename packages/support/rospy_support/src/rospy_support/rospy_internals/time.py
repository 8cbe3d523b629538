"""The clock of rospy."""
import rospy.impl.simtime
import rospy.rostime


def set_time(now):
    """Set the ROS time of this process, as a message on /clock does; ``now`` is a rospy.Time."""
    rospy.rostime._set_rostime(now)


def follow_time():
    """Take the time from /clock if /use_sim_time is true, else from the wall clock. Return whether that worked.

    init_node does the same, unless it is called with ``disable_rostime``.
    """
    return rospy.impl.simtime.init_simtime()


def is_wall_time():
    """Return whether rospy takes its time from the wall clock."""
    return rospy.rostime.is_wallclock()
