"""The common basis of all programs, without ROS.

* The names below check values from outside, write files completely or not at all, and detect truncated images.
* ``documents`` reads untrusted YAML and XML; it needs PyYAML.
* ``processes`` starts, finds and ends processes; it needs psutil. ``sockets`` finds the process at the other end.
* ``rotations`` converts matrices, quaternions and angles, ``arrays`` names types of arrays; they need numpy.
* ``course`` reads the steps of the course; it needs PyYAML. ``packages`` finds folders of ROS packages, by rospkg.
* ``doctor`` finds problems of a machine with ROS, and says how to fix them.

Unless a library is named, a module needs only the standard library.
"""
from plain_support.encoded_images import is_truncated
from plain_support.files import create_numbered, create_whole, unwritten, write_together, write_whole
from plain_support.validation import ABSURD, LARGEST_MARKER_ID, InvalidInput, require_sane, shown

__all__ = ['ABSURD', 'LARGEST_MARKER_ID', 'InvalidInput', 'create_numbered', 'create_whole', 'is_truncated',
           'require_sane', 'shown', 'unwritten', 'write_together', 'write_whole']
