"""The tracker's parameters, and those that dynamic_reconfigure changes while the node runs."""
import math
import xmlrpc.client
from dataclasses import dataclass

import rosgraph
import rospy
from dynamic_reconfigure.server import Server

from alvar_core.code import MARGIN, MAX_MARGIN, MAX_RESOLUTION, MIN_RESOLUTION, CodeError, check_resolution
from alvar_core.detection.light import GAMMAS
from alvar_core.detection.thresholds import MAX_CANDIDATES
from ar_track_alvar.cfg import ParamsConfig
from rospy_support import parameters
from rospy_support.parameters import Boolean, Integer, Number, Table, Text

LEARNT = 0.0  # of ~gamma: it is learnt from the markers
RAW, RECTIFIED, AUTO = 'raw', 'rectified', 'auto'
DEFAULT, LOW, HIGH = ParamsConfig.defaults, ParamsConfig.min, ParamsConfig.max  # of cfg/Params.cfg


def _changeable(name, unit='', clamp=True):
    """Return a parameter that can be changed while the tracker runs, with the default and range of that setting.

    ``clamp``: values out of range are replaced by the nearest limit; the original accepts them, and there are launch
    files with 60 Hz.
    """
    return Number(f'~{name}', DEFAULT[name], LOW[name], HIGH[name], unit, clamp=clamp)


PARAMETERS = Table(
    Boolean('~enabled', DEFAULT['enabled']), _changeable('max_frequency', 'Hz'),
    _changeable('marker_size', 'cm', clamp=False), _changeable('max_new_marker_error'), _changeable('max_track_error'),
    Integer('~marker_resolution', MIN_RESOLUTION, MIN_RESOLUTION, MAX_RESOLUTION, 'cells'),
    Integer('~marker_margin', MARGIN, 1, MAX_MARGIN, 'cells'),
    Number('~gamma', LEARNT, LEARNT, GAMMAS[1]), Integer('~max_candidates', MAX_CANDIDATES, 1, 10000),
    Text('~output_frame', ''),
    Text('~image_transport', 'raw', ('raw', 'compressed')), Text('~image_geometry', AUTO, (AUTO, RAW, RECTIFIED)),
    Number('~transform_tolerance', 0.1, 0.0, 10.0, 's'))

FRAME_FROM_MESSAGE = Boolean('~output_frame_from_msg', False)  # only for clouds, as in the original


@dataclass
class Settings:
    """The parameters by their names; marker_size [cm], max_frequency [Hz], transform_tolerance [s]."""

    enabled: bool
    max_frequency: float
    marker_size: float
    max_new_marker_error: float
    max_track_error: float
    marker_resolution: int
    marker_margin: int
    gamma: float
    max_candidates: int
    output_frame: str
    image_geometry: str
    transform_tolerance: float
    image_transport: str = 'raw'


def read(declared=PARAMETERS, frame_from_message=False):
    """Return the Settings; raises params.ParameterError.

    ``declared`` are the parameters of the node; with ``frame_from_message``, ~output_frame is not needed.
    """
    names = set(Settings.__annotations__)
    settings = Settings(**{parameter.name[1:]: parameter.read() for parameter in declared
                           if parameter.name[1:] in names})
    settings.output_frame = settings.output_frame.lstrip('/')
    if not settings.output_frame and not frame_from_message:
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name("~output_frame")} must be set: the tf frame of the '
            'published markers, such as that of the camera; set it with _output_frame:=FRAME on the command line or in '
            'the launch file')
    if settings.gamma and settings.gamma < GAMMAS[0]:
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name("~gamma")} is {settings.gamma:g}: it must be from {GAMMAS[0]:g}, if the '
            f'values of the images are proportional to light, to {GAMMAS[1]:g}, or {LEARNT:g}: learnt from the markers')
    try:
        check_resolution(settings.marker_resolution)
    except CodeError as error:
        raise parameters.ParameterError(f'parameter {rospy.resolve_name("~marker_resolution")}: {error}') from None
    return settings


class LiveSettings:
    """Lets dynamic_reconfigure change a Settings; calls ``on_change()`` after every change, in rospy's threads."""

    def __init__(self, settings, on_change):
        self._settings, self._on_change = settings, on_change
        for name in ParamsConfig.defaults:  # as floats, because dynamic_reconfigure treats whole numbers as int
            rospy.set_param(f'~{name}', getattr(settings, name))
        self._server = Server(ParamsConfig, self._changed)

    def enable(self, enabled):
        """Switch detection on or off, and tell the clients of dynamic_reconfigure."""
        self._update({'enabled': bool(enabled)})

    def restore(self):
        """Set the parameters again on a restarted master."""
        self._update({})

    def _update(self, changes):
        try:
            self._server.update_configuration(changes)
        except (OSError, rosgraph.MasterException, xmlrpc.client.Error) as error:  # the change still takes effect
            rospy.logwarn('Cannot write a change to the parameter server: %s', error)

    def _changed(self, config, _):
        for name in ParamsConfig.defaults:
            if not math.isfinite(config[name]):
                rospy.logwarn('dynamic_reconfigure: %s is %s; it must be a finite number; it stays %s', name,
                              config[name], getattr(self._settings, name))
                config[name] = getattr(self._settings, name)
            setattr(self._settings, name, config[name])
        self._on_change()
        return config
