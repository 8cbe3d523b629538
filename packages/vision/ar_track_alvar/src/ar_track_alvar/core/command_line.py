"""Convert the original's deprecated command line into remappings and private parameters."""
import json
import math
import shlex
from typing import List, Sequence, Union

EXAMPLE = '_marker_size:=10 _output_frame:=camera camera_image:=/camera/image_raw camera_info:=/camera/camera_info'
USAGE = ('SIZE_CM MAX_NEW_MARKER_ERROR MAX_TRACK_ERROR IMAGE_TOPIC CAMERA_INFO_TOPIC OUTPUT_FRAME '
         '[MAX_FREQUENCY [MARKER_RESOLUTION [MARKER_MARGIN]]]')
BUNDLE_USAGE = f'{USAGE[:USAGE.index(" [")]} BUNDLE_FILE...'
DEPTH_EXAMPLE = ('_marker_size:=10 _output_frame:=camera camera_image:=/camera/depth_registered/points '
                 'camera_info:=/camera/rgb/camera_info')
DEPTH_BUNDLE_USAGE = f'{USAGE[:USAGE.index(" [")]} MEDIAN_FILTER_SIZE BUNDLE_FILE...'.replace('IMAGE', 'CLOUD')
TRAINING_USAGE = f'NUMBER_OF_MARKERS {USAGE[:USAGE.index(" [")]}'
NEEDED = ('_marker_size', '_max_new_marker_error', '_max_track_error', 'camera_image', 'camera_info', '_output_frame')
OPTIONAL = ('_max_frequency', '_marker_resolution', '_marker_margin')


class UsageError(ValueError):
    """The positional arguments do not have the deprecated form."""


def ros_arguments(words: Sequence[str]) -> List[str]:
    """Return the ROS arguments (name:=value) for the positional ``words``; raise UsageError if these are wrong."""
    if len(words) < len(NEEDED):
        raise UsageError(f'{len(words)} arguments are given; at least {len(NEEDED)} are needed')
    if len(words) > len(NEEDED + OPTIONAL):
        raise UsageError(f'{len(words)} arguments are given; at most {len(NEEDED + OPTIONAL)} are allowed')
    return [f'{name}:={_value(name, word)}' for name, word in zip(NEEDED + OPTIONAL, words)]


def bundle_arguments(words: Sequence[str]) -> List[str]:
    """Return the ROS arguments for the form with one or more bundle files after the frame."""
    if len(words) <= len(NEEDED):
        raise UsageError(f'{len(words)} arguments are given; at least {len(NEEDED) + 1} are needed')
    files = json.dumps(shlex.join(words[len(NEEDED):]))
    return ros_arguments(words[:len(NEEDED)]) + [f'_bundle_files:={files}']


def depth_bundle_arguments(words: Sequence[str]) -> List[str]:
    """Return the ROS arguments for the form with the size of the median filter and bundle files after the frame."""
    place = len(NEEDED)
    if len(words) < place + 2:
        raise UsageError(f'{len(words)} arguments are given; at least {place + 2} are needed')
    return bundle_arguments([*words[:place], *words[place + 1:]]) + [
        f'_med_filt_size:={_value("_med_filt_size", words[place])}']


def training_arguments(words: Sequence[str]) -> List[str]:
    """Return the ROS arguments for the form with the number of markers before all others."""
    if len(words) != len(NEEDED) + 1:
        raise UsageError(f'{len(words)} arguments are given; {len(NEEDED) + 1} are needed')
    return [f'_nof_markers:={_value("_nof_markers", words[0])}', *ros_arguments(words[1:])]


def _value(name: str, word: str) -> Union[int, str]:
    if name == '_output_frame':
        return json.dumps(word)  # a frame may look like a number
    if not name.startswith('_'):
        return word
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f'{name[1:].upper()} is {word!r}; a number is needed')
    return int(number) if number.is_integer() else f'{number:f}'  # YAML reads 1e-05 as a text
