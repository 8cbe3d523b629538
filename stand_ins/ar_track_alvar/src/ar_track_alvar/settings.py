"""The tracker's parameters."""
from dataclasses import dataclass

import rospy

from alvar_core.code import MAX_RESOLUTION, MIN_RESOLUTION, CodeError, check_resolution
from ar_track_alvar.cfg import ParamsConfig
from rospy_support import parameters

RAW, RECTIFIED, AUTO = 'raw', 'rectified', 'auto'
DEFAULT, LOW, HIGH = ParamsConfig.defaults, ParamsConfig.min, ParamsConfig.max  # of cfg/Params.cfg


@dataclass
class Settings:
    """Parameters by their names; marker_size in cm, max_frequency in Hz, transform_tolerance in s."""

    enabled: bool
    max_frequency: float
    marker_size: float
    max_new_marker_error: float
    max_track_error: float
    marker_resolution: int
    marker_margin: int
    output_frame: str
    image_transport: str
    image_geometry: str
    transform_tolerance: float


def read():
    """Return the Settings; raises params.ParameterError."""
    settings = Settings(
        enabled=parameters.boolean('~enabled', DEFAULT['enabled']),
        max_frequency=_clamped('max_frequency', unit='Hz'),
        marker_size=parameters.number('~marker_size', DEFAULT['marker_size'], LOW['marker_size'], HIGH['marker_size'],
                                  unit='cm'),
        max_new_marker_error=_clamped('max_new_marker_error'),
        max_track_error=_clamped('max_track_error'),
        marker_resolution=parameters.integer('~marker_resolution', 5, MIN_RESOLUTION, MAX_RESOLUTION, unit='cells'),
        marker_margin=parameters.integer('~marker_margin', 2, 1, 10, unit='cells'),
        output_frame=parameters.text('~output_frame', '').lstrip('/'),
        image_transport=parameters.text('~image_transport', 'raw', choices=('raw', 'compressed')),
        image_geometry=parameters.text('~image_geometry', AUTO, choices=(AUTO, RAW, RECTIFIED)),
        transform_tolerance=parameters.number('~transform_tolerance', 0.1, 0.0, 10.0, unit='s'))
    if not settings.output_frame:
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name("~output_frame")} has to be set: the tf frame in '
                                    'which markers are reported, such as the camera\'s own; set it with '
                                    '_output_frame:=FRAME on the command line or in the launch file')
    try:
        check_resolution(settings.marker_resolution)
    except CodeError as error:
        raise parameters.ParameterError(f'parameter {rospy.resolve_name("~marker_resolution")}: {error}') from None
    return settings


def _clamped(name, unit=''):
    """Return a parameter that the original takes beyond its range, too: launch files with 60 Hz are about."""
    return parameters.number(f'~{name}', DEFAULT[name], LOW[name], HIGH[name], unit=unit, clamp=True)
