"""Camera calibrations: YAML files of ROS's camera_calibration, their paths, and an approximation. Without ROS."""
import math
import os
import re
from dataclasses import asdict, dataclass, fields
from typing import Any, Callable, Dict, Optional, Tuple, Union

import yaml

from plain_support import documents, shown, write_whole
from plain_support.documents import DocumentError

Numbers = Tuple[float, ...]

DEFAULT_URL = 'file://${ROS_HOME}/camera_info/${NAME}.yaml'  # the default of camera_info_manager
COEFFICIENTS = {'plumb_bob': (0, 4, 5), 'rational_polynomial': (0, 8, 12, 14), 'equidistant': (0, 4)}  # numbers of D
MATRICES = {'camera_matrix': (3, 3), 'rectification_matrix': (3, 3), 'projection_matrix': (3, 4)}  # rows, columns
LARGEST_SIDE = 100_000  # [px]
ROI = {'x_offset': 0, 'y_offset': 0, 'height': 0, 'width': 0, 'do_rectify': False}


class CalibrationError(ValueError):
    """A calibration cannot be used; the text names the file, the key and what is allowed."""


@dataclass(frozen=True)
class Calibration:
    """The calibration of a camera; its fields are the keys of the file. Raises CalibrationError for impossible values.

    image_width, image_height [px]; the matrices row by row, K [px] with fx and fy above 0; distortion_coefficients in
    the order of sensor_msgs/CameraInfo; binning and roi as there, 0: none.
    """

    image_width: int
    image_height: int
    camera_name: str
    camera_matrix: Numbers
    distortion_model: str
    distortion_coefficients: Numbers
    rectification_matrix: Numbers
    projection_matrix: Numbers
    binning_x: int = 0
    binning_y: int = 0
    roi: Tuple[Tuple[str, Any], ...] = tuple(ROI.items())

    def __post_init__(self) -> None:
        for key, least in (('image_width', 1), ('image_height', 1), ('binning_x', 0), ('binning_y', 0)):
            value = getattr(self, key)
            if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= LARGEST_SIDE:
                raise CalibrationError(f'{key} is {shown(value)}; it must be a whole number from {least} to '
                                       f'{LARGEST_SIDE}')
        allowed = COEFFICIENTS.get(self.distortion_model)
        if allowed is None:
            raise CalibrationError(f'distortion_model is {shown(self.distortion_model)}; it must be one of '
                                   f'{", ".join(COEFFICIENTS)}')
        if len(self.distortion_coefficients) not in allowed:
            raise CalibrationError(f'distortion_coefficients has {len(self.distortion_coefficients)} numbers; '
                                   f'{self.distortion_model} needs {" or ".join(map(str, allowed[1:]))}')
        for key in (*MATRICES, 'distortion_coefficients'):
            if not all(map(math.isfinite, getattr(self, key))):
                raise CalibrationError(f'{key} is {shown(list(getattr(self, key)))}; all of it must be finite')
        if self.camera_matrix[0] <= 0.0 or self.camera_matrix[4] <= 0.0:
            raise CalibrationError(f'camera_matrix has fx = {self.camera_matrix[0]:g} and fy = '
                                   f'{self.camera_matrix[4]:g}; both must be above 0')

    @property
    def size(self) -> Tuple[int, int]:
        """Return (width, height) [px] of the images that the calibration is for."""
        return self.image_width, self.image_height


def read(path: str) -> Calibration:
    """Return the Calibration in a file; raise FileNotFoundError, or CalibrationError if it is malformed."""
    try:
        return _parse_document(documents.read_yaml(path))
    except FileNotFoundError:
        raise
    except (CalibrationError, DocumentError, OSError) as error:
        raise CalibrationError(f'{path}: {getattr(error, "strerror", None) or error}') from None


def parse(text: Union[str, bytes]) -> Calibration:
    """Return the Calibration in the text of a YAML file; raise CalibrationError with the key."""
    try:
        return _parse_document(documents.parse_yaml(text))
    except DocumentError as error:
        raise CalibrationError(str(error)) from None


def _parse_document(document: Any) -> Calibration:
    if not isinstance(document, dict):
        raise CalibrationError('not a calibration: it must have the keys image_width, camera_matrix and so on')
    values = {key: _matrix(document, key, *shape) for key, shape in MATRICES.items()}
    model = document.get('distortion_model', 'plumb_bob')  # missing in old files; as in camera_calibration_parsers
    roi = document.get('roi', {})
    if not isinstance(roi, dict):
        raise CalibrationError(f'roi is {shown(roi)}; it must hold {", ".join(ROI)}')
    return Calibration(
        image_width=_entry(document, 'image_width'), image_height=_entry(document, 'image_height'),
        camera_name=str(document.get('camera_name', 'unknown')), distortion_model=str(model),
        distortion_coefficients=_matrix(document, 'distortion_coefficients'),
        binning_x=document.get('binning_x', 0), binning_y=document.get('binning_y', 0),
        roi=tuple((key, _roi_entry(key, roi.get(key, default), default)) for key, default in ROI.items()), **values)


def write(path: str, calibration: Calibration) -> None:
    """Write a Calibration to a file for ``read`` and ROS's parsers, completely or not at all; raise OSError."""
    document = asdict(calibration)
    shapes: Dict[str, Tuple[int, Optional[int]]] = {**MATRICES, 'distortion_coefficients': (1, None)}
    for key, (rows, columns) in shapes.items():
        data = [float(value) for value in document[key]]
        document[key] = {'rows': rows, 'cols': columns or len(data), 'data': data}
    document['roi'] = dict(calibration.roi)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_whole(path, yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=math.inf))


def approximate(width: int, height: int, horizontal_fov: float) -> Calibration:
    """Return the Calibration of an ideal camera: square pixels, axis through the middle, no distortion.

    width, height [px]; horizontal_fov [degrees], between 0 and 180. (0, 0) is the centre of the top left pixel.
    """
    f = width / 2.0 / math.tan(math.radians(horizontal_fov) / 2.0)
    cx, cy = (width - 1) / 2.0, (height - 1) / 2.0
    return Calibration(width, height, '', (f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0), 'plumb_bob', (0.0,) * 5,
                       (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                       (f, 0.0, cx, 0.0, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0))


def locate(url: str, name: str, ros_home: str, package_path: Callable[[str], str]) -> str:
    """Return the path of a camera_info_url, as camera_info_manager reads it; '' means DEFAULT_URL.

    ``name`` stands for ${NAME}, ``ros_home`` for ${ROS_HOME}; ``package_path(package)`` returns a package's folder and
    raises LookupError. Raises CalibrationError.
    """
    known = {'${NAME}': name, '${ROS_HOME}': ros_home}
    resolved = re.sub(r'\$\{\w+\}', lambda found: known.get(found[0], found[0]), url or DEFAULT_URL)
    file = re.fullmatch(r'file://(/.+)', resolved, re.IGNORECASE)
    package = re.fullmatch(r'package://([^/]+)(/.+)', resolved, re.IGNORECASE)
    if file and '${' not in resolved:
        return file[1]
    if package and '${' not in resolved:
        try:
            return package_path(package[1]) + package[2]
        except LookupError:
            raise CalibrationError(f'camera_info_url {url!r}: there is no package {package[1]!r}') from None
    raise CalibrationError(f'camera_info_url is {url!r}; it must be file:///FOLDER/FILE.yaml or '
                           f'package://PACKAGE/FILE.yaml (with {", ".join(known)} where you like), or empty for '
                           f'{DEFAULT_URL}')


def _entry(document: Dict[str, Any], key: str) -> Any:
    if key not in document:
        keys = ', '.join(field.name for field in fields(Calibration)[:8])
        raise CalibrationError(f'{key} is missing; a calibration has {keys}')
    return document[key]


def _matrix(document: Dict[str, Any], key: str, rows: Optional[int] = None, columns: Optional[int] = None) -> Numbers:
    """Return the numbers of a matrix {rows, cols, data}; if ``rows`` is given it must have that size."""
    matrix = _entry(document, key)
    if not isinstance(matrix, dict) or not isinstance(matrix.get('data'), list):
        raise CalibrationError(f'{key} is {shown(matrix)}; it must hold rows, cols and data: [...]')
    shape: Tuple[Any, Any] = matrix.get('rows'), matrix.get('cols')
    count = len(matrix['data'])
    if rows is not None and shape != (rows, columns):
        raise CalibrationError(f'{key} has rows and cols {shown(shape)}; it must be ({rows}, {columns})')
    if not all(isinstance(side, int) for side in shape) or shape[0] * shape[1] != count:
        raise CalibrationError(f'{key} has {count} numbers in data, but rows and cols are {shown(shape)}')
    try:
        return tuple(_number(value) for value in matrix['data'])
    except (TypeError, ValueError, OverflowError):
        raise CalibrationError(f'{key} is {shown(matrix["data"])}; all of it must be numbers') from None


def _number(value: Any) -> float:
    if isinstance(value, bool):
        raise TypeError
    return float(value)  # also for a str: other parsers write 1e-05, which PyYAML reads as a str


def _roi_entry(key: str, value: Any, default: Union[int, bool]) -> Union[int, bool]:
    if type(value) is not type(default) or not 0 <= value <= LARGEST_SIDE:
        raise CalibrationError(f'roi: {key} is {shown(value)}; it must be '
                               f'{"true or false" if default is False else f"a whole number from 0 to {LARGEST_SIDE}"}')
    return value
