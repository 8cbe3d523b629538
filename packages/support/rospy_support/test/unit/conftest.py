"""What rospy logs in a test."""
import pytest
import rospy


@pytest.fixture
def logged(monkeypatch):
    """Return the list of the lines that are logged, whatever their level."""
    lines = []
    for level in ('loginfo', 'logwarn', 'logerr', 'logfatal'):
        monkeypatch.setattr(rospy, level, lambda text, *values: lines.append(text % values))
    return lines
