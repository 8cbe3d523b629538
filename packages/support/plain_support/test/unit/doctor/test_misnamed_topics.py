"""doctor.ros_checks and names: misspelled names of topics are found, usual systems are left alone."""
import pytest

from plain_support.doctor import names, ros_checks
from plain_support.doctor.master import Graph

TYPES = {'cmd_vel': 'geometry_msgs/Twist', 'pose': 'turtlesim/Pose', 'Pose': 'turtlesim/Pose',
         'cmdvel': 'geometry_msgs/Twist', 'goal': 'actionlib_tutorials/FibonacciActionGoal',
         'image_raw': 'sensor_msgs/Image', 'tf_static': 'tf2_msgs/TFMessage', 'joint_states': 'sensor_msgs/JointState',
         'color_sensor': 'turtlesim/Color', 'cancel': 'actionlib_msgs/GoalID', 'odom': 'nav_msgs/Odometry'}
SIMULATOR = '/turtlesim: </turtle1/cmd_vel >/turtle1/pose >/turtle1/color_sensor >/turtlesim/image_raw >/rosout'
ROBOT = '/robot: </cmd_vel >/odom >/camera/image_raw >/joint_states'


def graph(*nodes):
    """Return a Graph of lines such as /node: <read >published."""
    published, read = {}, {}
    for line in nodes:
        node, *ends = line.split()
        for end in ends:
            (read if end[0] == '<' else published).setdefault(end[1:], []).append(node[:-1])
    kinds = {topic: TYPES.get(topic.rsplit('/', 1)[-1], 'std_msgs/String') for topic in (*published, *read)}
    return Graph(1, {}, {}, published, {}, read, kinds)


@pytest.mark.parametrize('nodes, said', [
    ([SIMULATOR, '/a: >/turtle/cmd_vel'],
     ['/a publishes /turtle/cmd_vel, which nobody reads: did you mean /turtle1/cmd_vel?']),
    ([SIMULATOR, '/a: >/cmd_vel', '/teleop: >/turtle1/cmd_vel'], ['/a publishes /cmd_vel, ... mean /turtle1/cmd_vel?']),
    ([SIMULATOR, '/a: >/turtle1/cmdvel'], ['/a publishes /turtle1/cmdvel, ... mean /turtle1/cmd_vel?']),
    ([SIMULATOR, ROBOT, '/a: >/turtle/cmd_vel'], ['/a publishes /turtle/cmd_vel, ... mean /turtle1/cmd_vel?']),
    ([SIMULATOR, '/a: >/turtle/cmd_vel', '/rostopic_12_345: </turtle/cmd_vel'], ['/a publishes /turtle/cmd_vel, ...']),
    ([SIMULATOR, '/a: </turtle1/Pose'], ['/a subscribes to /turtle1/Pose, ... mean /turtle1/pose?']),
    ([SIMULATOR, '/a: </turtle2/pose'], ['/a subscribes to /turtle2/pose, ... mean /turtle1/pose?']),
    ([ROBOT, '/a: </usb_cam/image_raw'], ['/a subscribes to /usb_cam/image_raw, ... mean /camera/image_raw?']),
    (['/talker: >/chatter', '/a: </chater'], ['/a subscribes to /chater, ... mean /chatter?']),
    (['/a: </turtle1/pose'], ['/a subscribes to /turtle1/pose, which nobody publishes']),
])
def test_misspelled_names(nodes, said):
    found = [finding.text for finding in ros_checks.misnamed(graph(*nodes))]
    assert len(found) == len(said)
    for text, expected in zip(found, said):
        assert all(part in text for part in expected.split('...'))


@pytest.mark.parametrize('nodes', [
    [], [SIMULATOR], [SIMULATOR, ROBOT],
    [SIMULATOR, ROBOT, '/teleop: >/turtle1/cmd_vel'],  # the robot waits for commands
    ['/turtlesim: </turtle1/cmd_vel </turtle2/cmd_vel >/turtle1/pose >/turtle2/pose', '/listener: >/turtle2/cmd_vel',
     '/a: </turtle1/pose'],  # no node reads the pose of turtle2
    ['/a: >/turtle1/cmd_vel'], ['/listener: </chatter'],  # whose partner has not been started
    [SIMULATOR, '/tf: </tf_static </tf'], ['/server: </fibonacci/goal </fibonacci/cancel'],
    [ROBOT, '/publisher: </publisher/joint_states', '/camera: </gazebo/moving_panels'],  # inputs that may stay unused
    [SIMULATOR, '/both: >/turtle1/cmd_vel >/turtle9/cmd_vel'],
])
def test_usual_systems(nodes):
    assert [finding.text for finding in ros_checks.misnamed(graph(*nodes))] == []


@pytest.mark.parametrize('asked, said', [
    ({'/turtlesim': 'turtlesim/Pose', '/a': 'geometry_msgs/Twist'},
     ['both ends of /turtle1/pose need the same type: /a has geometry_msgs/Twist, /turtlesim has turtlesim/Pose']),
    ({'/turtlesim': 'turtlesim/Pose', '/a': 'turtlesim/Pose'}, []),
    ({'/turtlesim': 'turtlesim/Pose', '/a': '*'}, []),  # rostopic hz reads every type
    ({'/turtlesim': 'turtlesim/Pose'}, []),  # a node that does not answer
])
def test_two_types(asked, said):
    def types_of(nodes):
        return {node: {'/turtle1/pose': kind} for node, kind in asked.items() if node in nodes}
    found = list(ros_checks.two_types(graph(SIMULATOR, '/a: </turtle1/pose'), types_of))
    assert ([finding.text for finding in found], [finding.fails for finding in found]) == (said, [True] * len(said))


@pytest.mark.parametrize('name, known, meant', [
    ('/turtle/cmd_vel', {'/turtle1/cmd_vel', '/turtle1/pose'}, '/turtle1/cmd_vel'),
    ('/cmd_vel', {'/turtle1/cmd_vel', '/robot/CMD_VEL'}, '/turtle1/cmd_vel'),
    ('/turtle1/cmdvel', {'/turtle1/cmd_vel', '/turtle1/pose'}, '/turtle1/cmd_vel'),
    ('/turtle/cmd_vel', {'/cmd_vel', '/turtle1/cmd_vel'}, '/turtle1/cmd_vel'),  # the more similar one of two
    ('/chatter', {'/turtle1/pose'}, None), ('/a', set(), None),
])
def test_the_name_that_is_meant(name, known, meant):
    assert names.meant(name, known) == meant
