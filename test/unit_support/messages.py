"""Message classes as genpy makes them, without ROS."""


class Time:
    """genpy's Time and Duration."""

    def __init__(self, secs=0, nsecs=0):
        self.secs, self.nsecs = secs, nsecs


DEFAULTS = {'string': '', 'bool': False, 'float32': 0.0, 'float64': 0.0, 'uint8[]': b'', 'char[]': b'',
            'uint8[4]': b'\0' * 4, 'float64[3]': [0.0] * 3}


def message_class(name, classes=None, **fields):
    """Return a class of messages; ``classes``: those of its fields that are messages."""
    def default(kind):
        if kind in ('time', 'duration'):
            return Time()
        if kind in (classes or {}):
            return classes[kind]()
        return DEFAULTS.get(kind, [] if kind.endswith(']') else 0)

    def init(self, **values):
        for field, kind in fields.items():
            setattr(self, field, values.get(field, default(kind)))
    return type(name.rpartition('/')[2], (), {
        '__slots__': list(fields), '_slot_types': list(fields.values()), '_type': name, '__init__': init})


Point = message_class('geometry_msgs/Point', x='float64', y='float64', z='float64')
Header = message_class('std_msgs/Header', seq='uint32', stamp='time', frame_id='string')
CLASSES = {'geometry_msgs/Point': Point, 'std_msgs/Header': Header, 'time': Time, 'duration': Time}
Everything = message_class(
    'test_msgs/Everything', CLASSES, header='std_msgs/Header', flag='bool', small='int8', large='uint64', f='float32',
    d='float64', text='string', data='uint8[]', four='uint8[4]', ints='int32[]', floats='float64[]', three='float64[3]',
    flags='bool[]', texts='string[]', points='geometry_msgs/Point[]', point='geometry_msgs/Point', wait='duration',
    times='time[]')
