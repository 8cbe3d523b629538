"""The drive and the sensors of a robot, read from the plugins and sensors of an SDF <model>. No ROS.

Lengths in metres, angles in radians. A robot turns about its *centre*: the middle between the driven wheels, or the
origin of the model if it drives in any direction. Sensors stand in the frame of the centre, x forward, y to the left;
``ahead`` [m] is where the centre is in the frame of the model. Defaults are those of Gazebo's plugins.
"""
import math
import os
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple
from xml.etree.ElementTree import Element

import numpy as np

from kinematic_core.worlds.camera import HIGHEST_DEPTH, LOWEST_DEPTH
from kinematic_core.worlds.floor_plan import GREY, Colour
from plain_support import InvalidInput, shown
from sim_scene import meshes, sdf

LEVEL = 0.05  # [rad] if a laser or a camera is tilted more, a warning says that it is level here
DEFAULT_RADIUS, DEFAULT_HEIGHT = 0.1, 0.2  # [m] of a model without any shape
MOST_RAYS = 4096
SENSOR_HEIGHT = 0.03  # [m] of a sensor's body above its origin, so that other robots' lasers see it
FASTEST = 100.0  # [Hz] of any topic: one message a step


class Drive(NamedTuple):
    """The drive of a robot: ``separation`` and ``wheel_radius`` are 0 if it moves in any direction."""

    namespace: str
    command: str  # topics
    odometry: str
    odometry_frame: str
    base_frame: str
    rate: float  # [Hz] of the odometry
    left: Tuple[str, ...] = ()  # joints of the wheels
    right: Tuple[str, ...] = ()
    separation: float = 0.0
    wheel_radius: float = 0.0
    acceleration: float = 0.0  # [m/s^2] of a wheel's rim; 0: any
    timeout: float = math.inf  # [s] after the last command, at which the robot stops
    from_encoders: bool = False  # the odometry starts at the robot, not at the origin of the world
    publishes_transform: bool = True
    publishes_odometry: bool = True
    publishes_wheels: bool = False  # as joint_states


class Mount(NamedTuple):
    """The position and heading of a sensor on its robot."""

    x: float
    y: float
    z: float
    yaw: float


class Laser(NamedTuple):
    """A laser scanner; with ``field`` [rad] a single distance, a sensor_msgs/Range."""

    namespace: str
    topic: str
    frame: str
    rate: float
    mount: Mount
    rays: int
    first: float
    last: float
    nearest: float
    farthest: float
    noise: float
    field: float = 0.0
    radiation: str = ''


class Camera(NamedTuple):
    """A camera, and if ``depth`` is given, its depth image between these two distances."""

    namespace: str  # with the camera's own name
    image: str
    info: str
    frame: str
    rate: float
    mount: Mount
    width: int
    height: int
    field: float
    depth: Optional[Tuple[float, float]] = None
    depth_image: str = ''
    depth_info: str = ''
    points: str = ''


class Motion(NamedTuple):
    """A sensor of the motion of a robot: a sensor_msgs/Imu, or if ``is_pose`` a nav_msgs/Odometry in the world."""

    namespace: str
    topic: str
    frame: str
    base: str
    rate: float
    is_pose: bool


class Joints(NamedTuple):
    """Joints whose angles a plugin publishes."""

    namespace: str
    names: Tuple[str, ...]
    rate: float


class Contact(NamedTuple):
    """A bumper."""

    namespace: str
    topic: str
    frame: str
    rate: float


class Robot(NamedTuple):
    """The simulated parts of a model with plugins."""

    drive: Optional[Drive]
    lasers: Tuple[Laser, ...]
    cameras: Tuple[Camera, ...]
    motions: Tuple[Motion, ...]
    joints: Tuple[Joints, ...]
    contacts: Tuple[Contact, ...]
    radius: float
    height: float
    ahead: float
    colour: Colour
    warnings: Tuple[str, ...]


def is_robot(model: Element) -> bool:
    """Return whether a model has plugins or sensors of ROS."""
    return any(_file(plugin).startswith('libgazebo_ros') or _file(plugin) in READERS
               for plugin in model.iter('plugin'))


def read(model: Element, name: str, namespace: str = '', folder: str = '.') -> Robot:
    """Return the Robot that an SDF <model> describes; raise InvalidInput for impossible numbers.

    ``namespace`` is that of all plugins that do not name one.
    """
    return _Reader(model, name, namespace, folder).robot()


class _Reader:
    def __init__(self, model: Element, name: str, namespace: str, folder: str) -> None:
        self.warnings: List[str] = []
        self._model, self._name, self._namespace, self._folder = model, name, namespace, folder
        self._links = {link.get('name') or '': sdf.pose_of(name, link) for link in model.findall('link')}
        self.ahead = 0.0
        self.drives: List[Drive] = []
        self.lasers: List[Laser] = []
        self.cameras: List[Camera] = []
        self.motions: List[Motion] = []
        self.joints: List[Joints] = []
        self.contacts: List[Contact] = []

    def robot(self) -> Robot:
        sensors = {id(plugin): (link, sensor) for link in self._model.findall('link')
                   for sensor in link.findall('sensor') for plugin in sensor.findall('plugin')}
        plugins = list(self._model.iter('plugin'))
        plugins.sort(key=lambda plugin: _file(plugin) not in DRIVES)  # drives first, because they find the centre
        for plugin in plugins:
            reader = READERS.get(_file(plugin))
            if reader is None:
                self.warnings.append(f'the plugin {_file(plugin)} is not simulated')
            elif _file(plugin) in SENSORS and id(plugin) not in sensors:
                self.warnings.append(f'the plugin {_file(plugin)} is not in a <sensor>; it is left out')
            else:
                link, sensor = sensors.get(id(plugin), (None, None))
                reader(self, plugin, link, sensor)
        if len(self.drives) > 1:
            self.warnings.append(f'of {len(self.drives)} plugins that drive, only the first is used')
        radius, height, colour = self._body()
        mounts = [laser.mount for laser in self.lasers] + [camera.mount for camera in self.cameras]
        height = max([height, *(mount.z + SENSOR_HEIGHT for mount in mounts)])
        return Robot(self.drives[0] if self.drives else None, tuple(self.lasers), tuple(self.cameras),
                     tuple(self.motions), tuple(self.joints), tuple(self.contacts), radius, height, self.ahead, colour,
                     tuple(self.warnings))

    def space(self, plugin: Element) -> str:
        given = plugin.findtext('robotNamespace')
        return self._namespace if given is None else given.strip()

    def read_diff_drive(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        left, right = (_text(plugin, tag, tag[:-5] + '_joint') for tag in ('leftJoint', 'rightJoint'))
        self._add_wheeled(plugin, (left,), (right,))

    def read_skid_steer(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        left, right = (tuple(_text(plugin, f'{side}{end}Joint', f'{side}_{end.lower()}_joint')
                             for end in ('Front', 'Rear')) for side in ('left', 'right'))
        self._add_wheeled(plugin, left, right)

    def _add_wheeled(self, plugin: Element, left: Tuple[str, ...], right: Tuple[str, ...]) -> None:
        middles = [self._joint_place(joint) for joint in (*left, *right)]
        missing = [joint for joint, middle in zip((*left, *right), middles) if middle is None]
        if missing:
            raise InvalidInput(f'{self._name}: the plugin {_file(plugin)} names the joint {shown(missing[0])}, which '
                               'the model does not have')
        self.ahead = float(np.mean([middle[0] for middle in middles if middle is not None]))
        source = _text(plugin, 'odometrySource', 'world').lower()
        self.drives.append(Drive(
            self.space(plugin), _text(plugin, 'commandTopic', 'cmd_vel'), _text(plugin, 'odometryTopic', 'odom'),
            _text(plugin, 'odometryFrame', 'odom'), _text(plugin, 'robotBaseFrame', 'base_footprint'),
            self._rate(plugin, 'updateRate', 100.0), left, right,
            self._number(plugin, 'wheelSeparation', 0.34, 0.01, 10.0),
            self._number(plugin, 'wheelDiameter', 0.15, 0.01, 10.0) / 2.0,
            self._number(plugin, 'wheelAcceleration', 0.0, 0.0, 1000.0),
            from_encoders=source in ('encoder', '0'),
            publishes_transform=_flag(plugin, 'publishTf', True) and _flag(plugin, 'publishOdomTF', True),
            publishes_odometry=_flag(plugin, 'publishTf', True),
            publishes_wheels=_flag(plugin, 'publishWheelJointState', False)))

    def read_planar_move(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        timeout = self._number(plugin, 'cmdTimeout', -1.0, -math.inf, 3600.0)
        self.drives.append(Drive(
            self.space(plugin), _text(plugin, 'commandTopic', 'cmd_vel'), _text(plugin, 'odometryTopic', 'odom'),
            _text(plugin, 'odometryFrame', 'odom'), _text(plugin, 'robotBaseFrame', 'base_footprint'),
            self._rate(plugin, 'odometryRate', 20.0), timeout=timeout if timeout > 0.0 else math.inf))

    def read_laser(self, plugin: Element, link: Optional[Element], sensor: Optional[Element]) -> None:
        assert link is not None and sensor is not None  # because SENSORS lists it
        scan = _inner(sensor, 'scan/horizontal')
        rays = self._number(scan, 'samples', 640, 1, MOST_RAYS) * self._number(scan, 'resolution', 1.0, 0.01, 100.0)
        nearest, farthest = self._span(sensor)
        self.lasers.append(Laser(
            self.space(plugin), _text(plugin, 'topicName', 'world'), _text(plugin, 'frameName', 'world'),
            self._rate(sensor, 'update_rate', FASTEST), self._mount(link, sensor), int(min(max(rays, 1), MOST_RAYS)),
            self._number(scan, 'min_angle', 0.0, -10.0, 10.0), self._number(scan, 'max_angle', 0.0, -10.0, 10.0),
            nearest, farthest, self._noise(sensor)))

    def read_range(self, plugin: Element, link: Optional[Element], sensor: Optional[Element]) -> None:
        assert link is not None and sensor is not None
        field = self._number(plugin, 'fov', 0.05, 0.001, math.pi)
        nearest, farthest = self._span(sensor)
        self.lasers.append(Laser(
            self.space(plugin), _text(plugin, 'topicName', 'range'), _text(plugin, 'frameName', 'world'),
            self._rate(plugin, 'updateRate', self._rate(sensor, 'update_rate', FASTEST)), self._mount(link, sensor), 15,
            -field / 2.0, field / 2.0, nearest, farthest, self._number(plugin, 'gaussianNoise', 0.0, 0.0, 10.0), field,
            _text(plugin, 'radiation', 'ultrasound')))

    def read_camera(self, plugin: Element, link: Optional[Element], sensor: Optional[Element]) -> None:
        self._add_camera(plugin, link, sensor, None)

    def read_depth_camera(self, plugin: Element, link: Optional[Element], sensor: Optional[Element]) -> None:
        near, far = (self._number(plugin, tag, default, 0.0, 1000.0)
                     for tag, default in (('pointCloudCutoff', 0.4), ('pointCloudCutoffMax', 5.0)))
        near = min(max(near, LOWEST_DEPTH), HIGHEST_DEPTH / 2.0)
        self._add_camera(plugin, link, sensor, (near, min(max(far, 2.0 * near), HIGHEST_DEPTH)))

    def _add_camera(self, plugin: Element, link: Optional[Element], sensor: Optional[Element],
                    depth: Optional[Tuple[float, float]]) -> None:
        assert link is not None and sensor is not None
        image = _inner(sensor, 'camera')
        width, height = (int(self._number(image, f'image/{tag}', default, 16, 4096))
                         for tag, default in (('width', 320), ('height', 240)))
        space = '/'.join(part for part in (self.space(plugin).rstrip('/'), _text(plugin, 'cameraName', '')) if part)
        rate = self._rate(plugin, 'updateRate', 0.0) or self._rate(sensor, 'update_rate', 30.0) or 30.0
        self.cameras.append(Camera(
            space, _text(plugin, 'imageTopicName', 'image_raw'), _text(plugin, 'cameraInfoTopicName', 'camera_info'),
            _text(plugin, 'frameName', 'world'), rate, self._mount(link, sensor),
            width, height,
            self._number(image, 'horizontal_fov', 1.047, 0.05, 2.8), depth,
            _text(plugin, 'depthImageTopicName', 'depth/image_raw'),
            _text(plugin, 'depthImageCameraInfoTopicName', 'depth/camera_info'),
            _text(plugin, 'pointCloudTopicName', 'points')))

    def read_imu(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        body = _text(plugin, 'bodyName', '')
        rate = self._rate(plugin, 'updateRate', 0.0) or self._rate(plugin, 'updateRateHZ', 0.0) or FASTEST
        self.motions.append(Motion(self.space(plugin), _text(plugin, 'topicName', 'imu'),
                                   _text(plugin, 'frameName', body), body, rate, False))

    def read_p3d(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        self.motions.append(Motion(self.space(plugin), _text(plugin, 'topicName', 'ground_truth'),
                                   _text(plugin, 'frameName', 'world'), _text(plugin, 'bodyName', ''),
                                   self._rate(plugin, 'updateRate', 0.0) or FASTEST, True))

    def read_joint_states(self, plugin: Element, _link: Optional[Element], _sensor: Optional[Element]) -> None:
        names = tuple(name for name in _text(plugin, 'jointName', '').replace(',', ' ').split() if name)
        self.joints.append(Joints(self.space(plugin), names, self._rate(plugin, 'updateRate', FASTEST)))

    def read_bumper(self, plugin: Element, _link: Optional[Element], sensor: Optional[Element]) -> None:
        assert sensor is not None
        self.contacts.append(Contact(self.space(plugin), _text(plugin, 'bumperTopicName', 'bumper_states'),
                                     _text(plugin, 'frameName', 'world'), self._rate(sensor, 'update_rate', FASTEST)))

    def _joint_place(self, name: str) -> Optional[np.ndarray]:
        """Return the position (3,) of a joint, which is that of its child link."""
        for joint in self._model.findall('joint'):
            if joint.get('name') == name:
                pose = self._links.get((joint.findtext('child') or '').strip())
                return None if pose is None else pose[:3, 3]
        return None

    def _mount(self, link: Element, sensor: Element) -> Mount:
        pose = self._links[link.get('name') or ''] @ sdf.pose_of(self._name, sensor)
        if math.acos(min(1.0, max(-1.0, float(pose[2, 2])))) > LEVEL:
            self.warnings.append(f'the sensor {sensor.get("name")} is tilted; here it is level')
        return Mount(float(pose[0, 3]) - self.ahead, float(pose[1, 3]), float(pose[2, 3]),
                     math.atan2(pose[1, 0], pose[0, 0]))

    def _span(self, sensor: Element) -> Tuple[float, float]:
        limits = _inner(sensor, 'range')
        return (self._number(limits, 'min', 0.0, 0.0, 1000.0), self._number(limits, 'max', 10.0, 0.01, 1e9))

    def _noise(self, sensor: Element) -> float:
        noise = _inner(sensor, 'noise')
        return self._number(noise, 'stddev', 0.0, 0.0, 10.0)

    def _rate(self, element: Element, tag: str, default: float) -> float:
        try:
            return min(self._number(element, tag, default, 0.0, 1e9), FASTEST)
        except InvalidInput as error:  # Gazebo goes on, and public models have '${update_rate}'
            self.warnings.append(f'{error}; {default:g} is used')
            return default

    def _number(self, element: Element, tag: str, default: float, low: float, high: float) -> float:
        text = (element.findtext(tag) or '').strip()
        if not text:
            return default
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not low <= number <= high:
            raise InvalidInput(f'{self._name}: <{tag}> is {shown(text)}; it must be a number from {low:g} to {high:g}')
        return number

    def _body(self) -> Tuple[float, float, Colour]:
        """Return radius and height of a cylinder that replaces the robot's shapes, and the colour of the first shape.

        The radius is the mean of the distances from the centre to the outline ahead, behind, left and right.
        """
        for tag in ('collision', 'visual'):
            found = [corners for link in self._model.findall('link') for part in link.findall(tag)
                     for corners in self._corners(self._links[link.get('name') or ''], part)]
            if found:
                break
        colours = [colour for visual in self._model.iter('visual')
                   for colour in [sdf.colour_of(visual)] if colour is not None]
        colour = colours[0] if colours else GREY
        if not found:
            return DEFAULT_RADIUS, DEFAULT_HEIGHT, colour
        points = np.concatenate(found) - [self.ahead, 0.0, 0.0]
        low, high = points.min(0), points.max(0)
        radius = float(np.mean([*np.maximum(high[:2], 0.02), *np.maximum(-low[:2], 0.02)]))
        return radius, max(float(high[2]), 0.02), colour

    def _corners(self, link: np.ndarray, part: Element) -> List[np.ndarray]:
        """Return [(8, 3)] of the corners of the boxes around the geometry of a collision or visual."""
        geometry = part.find('geometry')
        if geometry is None:
            return []
        found = []
        for kind in list(geometry):
            box = self._bounds(kind)
            if box is not None:
                low, high = box
                corners = np.array([[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)])
                pose = link @ sdf.pose_of(self._name, part)
                found.append(corners @ pose[:3, :3].T + pose[:3, 3])
        return found

    def _bounds(self, kind: Element) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """Return the lowest and the highest corner (3,) of a geometry in its own frame."""
        if kind.tag == 'mesh':
            scale = np.array([float(word) for word in (kind.findtext('scale') or '1 1 1').split()])
            try:
                low, high = meshes.bounds(meshes.find((kind.findtext('uri') or '').strip(), self._folder))
            except InvalidInput:
                return None
            return np.minimum(low * scale, high * scale), np.maximum(low * scale, high * scale)
        if kind.tag == 'box':
            half = np.array([float(word) for word in (kind.findtext('size') or '').split()]) / 2.0
        elif kind.tag == 'cylinder':
            radius = self._number(kind, 'radius', 0.0, 0.0, 1000.0)
            half = np.array([radius, radius, self._number(kind, 'length', 0.0, 0.0, 1000.0) / 2.0])
        elif kind.tag == 'sphere':
            half = np.full(3, self._number(kind, 'radius', 0.0, 0.0, 1000.0))
        else:
            return None
        if half.shape != (3,) or not np.isfinite(half).all():
            raise InvalidInput(f'{self._name}: <{kind.tag}> has impossible sizes')
        return -half, half


Read = Callable[[_Reader, Element, Optional[Element], Optional[Element]], None]
DRIVES: Dict[str, Read] = {'libgazebo_ros_diff_drive.so': _Reader.read_diff_drive,
                           'libgazebo_ros_skid_steer_drive.so': _Reader.read_skid_steer,
                           'libgazebo_ros_planar_move.so': _Reader.read_planar_move}
SENSORS: Dict[str, Read] = {
    'libgazebo_ros_laser.so': _Reader.read_laser, 'libgazebo_ros_gpu_laser.so': _Reader.read_laser,
    'libgazebo_ros_range.so': _Reader.read_range, 'libgazebo_ros_camera.so': _Reader.read_camera,
    'libgazebo_ros_openni_kinect.so': _Reader.read_depth_camera,
    'libgazebo_ros_depth_camera.so': _Reader.read_depth_camera, 'libgazebo_ros_bumper.so': _Reader.read_bumper}
READERS: Dict[str, Read] = {
    **DRIVES, **SENSORS, 'libgazebo_ros_imu.so': _Reader.read_imu, 'libgazebo_ros_imu_sensor.so': _Reader.read_imu,
    'libgazebo_ros_p3d.so': _Reader.read_p3d, 'libgazebo_ros_joint_state_publisher.so': _Reader.read_joint_states}


def _file(plugin: Element) -> str:
    name = os.path.basename(plugin.get('filename') or '')
    return name if name.endswith('.so') or not name else f'{name}.so'


def _inner(element: Element, path: str) -> Element:
    """Return the element ``path`` below ``element``, at any depth; an empty one if there is none."""
    found = element.find(f'.//{path}')
    return Element('missing') if found is None else found


def _text(element: Element, tag: str, default: str) -> str:
    found = element.findtext(tag)
    return default if found is None else found.strip()


def _flag(element: Element, tag: str, default: bool) -> bool:
    text = _text(element, tag, '').lower()
    return default if text not in ('true', 'false', '1', '0') else text in ('true', '1')
