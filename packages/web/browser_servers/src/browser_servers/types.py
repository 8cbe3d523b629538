"""Classes of messages and services by their names, and messages that stay serialised until a client needs them."""
import functools
from typing import Any, Callable, Tuple

import genpy
import genpy.dynamic
import roslib.message
import rospy

from browser_servers.core.conversion import Builder
from browser_servers.core.operations import Refused


def message_class(name: str) -> Any:
    """Return the class of a message type; raise Refused, with what to do."""
    return _class('message', roslib.message.get_message_class, name)


def service_class(name: str) -> Any:
    """Return the class of a service type; raise Refused, with what to do."""
    return _class('service', roslib.message.get_service_class, name)


def _class(what: str, find: Callable[[str], Any], name: str) -> Any:
    try:
        cls = find(name) if name.count('/') == 1 else None
    except Exception:  # importing another package can raise anything
        cls = None
    if cls is None:
        package = name.partition('/')[0]
        raise Refused(f'the {what} type {name!r} is not installed here; it must be like std_msgs/String, and the '
                      f'package {package} must be built and sourced where this server was started')
    return cls


def _element_class(name: str) -> Any:
    if name in ('time', 'duration'):
        return genpy.Time if name == 'time' else genpy.Duration
    try:
        return message_class(name)
    except Refused:
        return None


def now() -> Tuple[int, int]:
    """Return the ROS time as (secs, nsecs)."""
    time = rospy.get_rostime()
    return time.secs, time.nsecs


builder = Builder(_element_class, now)


@functools.lru_cache(maxsize=1000)
def raw_class(name: str, md5sum: str, definition: str) -> Any:
    """Return a class for messages of a type that stay serialised: ``_buff`` has the bytes."""
    return type('Raw', (rospy.AnyMsg,), {'_type': name, '_md5sum': md5sum, '_full_text': definition})


def raw_class_of(name: str) -> Any:
    """Return the class of serialised messages of a type, or of any type if the name is empty."""
    if not name:
        return rospy.AnyMsg
    cls = message_class(name)
    return raw_class(name, cls._md5sum, cls._full_text)


@functools.lru_cache(maxsize=1000)
def _class_of_definition(name: str, definition: str) -> Any:
    return genpy.dynamic.generate_dynamic(name, definition)[name]


def deserialise(name: str, definition: str, data: bytes) -> Any:
    """Return the message in ``data``; a type that is not installed is read with the publisher's definition."""
    try:
        cls = message_class(name)
    except Refused:
        if not definition:
            raise
        cls = _class_of_definition(name, definition)
    return cls().deserialize(data)
