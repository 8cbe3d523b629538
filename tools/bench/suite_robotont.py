"""The bench of robotont_gazebo: the speed of the simulator's parts, and the processor time of its nodes in real time.

"Times real time" is simulated seconds a second of one core.
"""

from figures import Figure, Target, mean_rate, median
from processes import tree_memory
from session import Measurement, answer, find_node, listened, seconds_to_first

PACKAGE = 'robotont_gazebo'
EXECUTABLE = 'robotont_gazebo'
WORLD = '_world:=minimaze_ar', '_x:=-2.0'


def start(subject, scale):
    """Measure the time from the start of the process to its first odometry at a waiting subscriber."""
    return {'start': seconds_to_first(subject, scale, 'odom', *WORLD)}


def colour(subject, scale):
    """Measure a camera of 1280 x 720 with one subscriber."""
    with subject.node(*WORLD), subject.other(find_node(PACKAGE, 'robotont_camera')) as eye:
        used, stamps = listened(subject, eye, scale, topic='camera/color/image_raw', turning=True)
        return {'colour_cpu': [used], 'colour_rate': [mean_rate(stamps)], 'colour_memory': [tree_memory(eye.pid)[0]]}


def core(subject, scale):
    """Measure the simulator's parts without ROS."""
    with subject.probe('core_probe', 'real_time', seconds=scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first odometry'),
    'colour': Measurement(colour, 'colour images of 1280 x 720'),
    'core': Measurement(core, 'kinematics, scanner, camera, tracker without ROS', in_process=True),
}
FIGURES = (
    Figure('start to first odometry', 'start', 's', median, Target('below', 1.0)),
    Figure('colour pictures', 'colour_rate', 'Hz'),
    Figure('CPU, colour pictures', 'colour_cpu', '% of a core', median, Target('below', 50.0)),
    Figure('memory, colour pictures', 'colour_memory', 'MB'),
    Figure('kinematics alone', 'kinematics', 'x real time', median, Target('at_least', 500.0)),
    Figure('kinematics and scanner', 'scanner', 'x real time', median, Target('at_least', 50.0)),
    Figure('kinematics, 640 x 480 camera, tracker at 7.5 Hz', 'tracker', 'x real time', median,
           Target('at_least', 8.0)),
    Figure('the same, tracker in every picture', 'tracker_each', 'x real time', median, Target('at_least', 10.0)),
)
