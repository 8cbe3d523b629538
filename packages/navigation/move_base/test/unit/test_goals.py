"""When a period takes a goal."""
from types import SimpleNamespace

import pytest
import rospy

from move_base.node import MoveBase

NOW = rospy.Time(20)


class Server:
    """An action server that drives to a goal and has got another one."""

    def __init__(self, stamp):
        self.next_goal = SimpleNamespace(get_goal_id=lambda: SimpleNamespace(stamp=stamp))
        self.taken, self.preempted = False, False
        self.is_active = self.is_preempt_requested = lambda: True

    def is_new_goal_available(self):
        return not self.taken

    def accept_new_goal(self):
        self.taken = True
        return SimpleNamespace(target_pose=None)

    def set_preempted(self, text):
        self.preempted = True


@pytest.mark.parametrize('stamp, taken', [(NOW, False), (NOW - rospy.Duration(0, 8_000_000), True)])
def test_a_goal_of_this_very_instant_waits_for_the_next_period(monkeypatch, stamp, taken):
    """Before, it was chance whether it was taken, so that a drive with the same seed took another way."""
    node = object.__new__(MoveBase)
    node._started, node._server = True, Server(stamp)
    for name, answer in (('_situation', ''), ('_silence', ''), ('_stop', None), ('_stop_unless_driving', None),
                         ('_in_map', (None, 'not this one')), ('_drive', None)):
        monkeypatch.setattr(node, name, lambda *_, answer=answer: answer, raising=False)
    node._server.set_aborted = lambda *_: setattr(node._server, 'is_active', lambda: False)
    node._period(NOW)
    assert node._server.taken is taken and not node._server.preempted
