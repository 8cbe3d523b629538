"""The program spawn_model: adds a robot or an object to the world of the node gazebo, then exits."""
from __future__ import annotations

import argparse
import sys
from typing import Sequence

import rospy
from gazebo_msgs.msg import ModelStates
from gazebo_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose, Quaternion
from std_srvs.srv import Empty
from tf.transformations import quaternion_from_euler

from rospy_support import nodes

PATIENCE = 5.0  # [s] after which it says that it waits for the simulator
INCLUDE = '<sdf version="1.4"><world name="default"><include><uri>model://{}</uri></include></world></sdf>'


def main() -> None:
    """Spawn a model; end with 1 if that fails."""
    options = _options(rospy.myargv()[1:])
    nodes.init_node('spawn_model', anonymous=True)
    if options.wait:
        _wait_for_model(options)
    service = f'{options.gazebo_namespace}/spawn_{"urdf" if options.urdf else "sdf"}_model'
    _wait_for(service)
    if options.joints:
        rospy.logwarn('Joints stay at 0: -J %s has no effect here.', ' '.join(name for name, _ in options.joints))
    answer = rospy.ServiceProxy(service, SpawnModel)(options.model, _text(options), options.robot_namespace,
                                                     _pose(options), options.reference_frame)
    if not answer.success:
        sys.exit(f'spawn_model: {answer.status_message}')
    rospy.loginfo('%s is in the world, at x=%g, y=%g.', options.model, options.x, options.y)
    if options.unpause:
        rospy.ServiceProxy(f'{options.gazebo_namespace}/unpause_physics', Empty)()
    if options.bond:
        delete = rospy.ServiceProxy(f'{options.gazebo_namespace}/delete_model', DeleteModel)
        rospy.on_shutdown(lambda: delete(options.model))
        rospy.spin()


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='spawn_model', description='Spawn a model.')
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument('-urdf', action='store_true', help='the model is URDF')
    kind.add_argument('-sdf', action='store_true', help='the model is SDF')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('-file', metavar='FILE', help='file of the model')
    source.add_argument('-param', metavar='NAME', help='ROS parameter that contains the model')
    source.add_argument('-database', metavar='NAME', help='name of the model, as in model://NAME')
    source.add_argument('-stdin', action='store_true', help='read the model from standard input')
    parser.add_argument('-model', metavar='NAME', required=True, help='name of the model in the world')
    parser.add_argument('-reference_frame', metavar='MODEL', default='', help='frame of the pose')
    parser.add_argument('-gazebo_namespace', metavar='NAME', default='/gazebo', help='namespace of the services')
    parser.add_argument('-robot_namespace', metavar='NAME', default=rospy.get_namespace(),
                        help='namespace of the topics of the model')
    parser.add_argument('-unpause', action='store_true', help='resume simulated time afterwards')
    parser.add_argument('-wait', metavar='MODEL', help='wait until this model exists')
    for name, what in (('x', 'm'), ('y', 'm'), ('z', 'm'), ('R', 'rad'), ('P', 'rad'), ('Y', 'rad')):
        parser.add_argument(f'-{name}', type=float, default=0.0, help=f'pose of the model: {name} [{what}]')
    parser.add_argument('-J', dest='joints', metavar=('JOINT', 'POSITION'), nargs=2, action='append', default=[],
                        help='no effect here')
    parser.add_argument('-package_to_model', action='store_true', help='no effect here')
    parser.add_argument('-b', dest='bond', action='store_true', help='keep running, and remove the model at the end')
    return parser.parse_args(arguments)


def _text(options: argparse.Namespace) -> str:
    """Return the URDF or SDF; end the program with a text if there is none."""
    if options.database:
        return INCLUDE.format(options.database)
    if options.stdin:
        return sys.stdin.read()
    if options.file:
        try:
            with open(options.file, encoding='utf-8') as file:
                return file.read()
        except (OSError, UnicodeDecodeError) as error:
            sys.exit(f'spawn_model: -file {options.file}: {getattr(error, "strerror", None) or error}')
    name = rospy.resolve_name(options.param)
    text = rospy.get_param(options.param, None)
    if not isinstance(text, str) or not text.strip():
        sys.exit(f'spawn_model: the parameter {name} contains no model; set it in the launch file, before this node: '
                 f'<param name="{options.param}" command="xacro FILE"/>')
    return text


def _pose(options: argparse.Namespace) -> Pose:
    pose = Pose(orientation=Quaternion(*quaternion_from_euler(options.R, options.P, options.Y)))
    pose.position.x, pose.position.y, pose.position.z = options.x, options.y, options.z
    return pose


def _wait_for(service: str) -> None:
    try:
        rospy.wait_for_service(service, PATIENCE)
    except rospy.ROSException:
        rospy.logwarn('Waiting for %s. Start the simulator: roslaunch gazebo_ros empty_world.launch', service)
        rospy.wait_for_service(service)


def _wait_for_model(options: argparse.Namespace) -> None:
    rospy.loginfo('Waiting for the model %s.', options.wait)
    while options.wait not in rospy.wait_for_message(f'{options.gazebo_namespace}/model_states', ModelStates).name:
        pass
