"""What programs of every kind stand on, without ROS.

* The names below: refuse values that make no sense for a robot, write whole files, find images that are cut off.
* ``documents`` reads untrusted YAML and XML; it needs PyYAML.
* ``processes`` starts, finds and ends processes; it needs psutil. ``sockets`` finds who is at the other end.
* ``doctor`` says what is wrong on a machine with ROS, and what to do about it.

All the rest needs only the standard library.
"""
from plain_support.encoded_images import is_truncated
from plain_support.files import create_numbered, create_whole, write_whole
from plain_support.validation import ABSURD, LARGEST_MARKER_ID, InvalidInput, require_sane, shown

__all__ = ['ABSURD', 'LARGEST_MARKER_ID', 'InvalidInput', 'create_numbered', 'create_whole', 'is_truncated',
           'require_sane', 'shown', 'write_whole']
