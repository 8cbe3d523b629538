"""course_grader.demo.cli: a slow machine makes the demo slow, never failed; a step that hangs ends it."""
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from course_grader.demo import cli, harness
from unit_support.cases import nightly

pytestmark = pytest.mark.slow


class Harness:
    """A demo without ROS."""

    def __init__(self, _):
        self.closed = False

    def open(self):
        """Start nothing."""

    def close(self):
        """End nothing."""


@pytest.fixture
def said(monkeypatch):
    texts = []
    monkeypatch.setattr(cli, 'DemoHarness', Harness)
    monkeypatch.setattr(cli, 'STEP_LIMIT', 1)
    monkeypatch.setattr(cli, 'play', lambda step, *_: time.sleep(step.seconds) or step.good)
    return texts


def play(texts, *seconds, good=True):
    steps = [SimpleNamespace(title=str(number), seconds=one, good=good) for number, one in enumerate(seconds)]
    report = SimpleNamespace(verdict=lambda good, text: texts.append(text))
    return cli.play_all(steps, '/nowhere', report)


def test_the_limit_holds_for_each_step_not_for_all(said):
    assert play(said, 0.6, 0.6, 0.6) == [] and said == []


def test_a_step_that_hangs_ends_the_demo(said):
    assert play(said, 0.0, 30.0, 0.0) == ['1', '2']
    assert said == ['Out of time: this step took more than 1 s. A node hangs, or the machine is too busy']


def test_a_turtle_may_rest_late_but_not_for_ever():
    """Its time counts, in poses: here a pose comes with each look."""
    made = harness.DemoHarness('/nowhere')
    poses = []
    made.until = lambda condition, *_: next(number for number in range(10000) if poses.append(
        SimpleNamespace(x=number, y=0.0, theta=0.0, linear_velocity=1.0, angular_velocity=0.0)) or condition())
    made.seen = SimpleNamespace(track=poses)
    made.until_rest()
    assert len(poses) == harness.REST_POSES + 1


PLAYED = """import sys; from course_grader.demo import cli; cli.play_all = lambda *_: []
sys.argv = ['demo', 'gotoPose']; cli.main()"""


@pytest.mark.parametrize('output, code, said', [
    ('>/dev/full', 1, './run demo: its output cannot be written: No space left on device\n'), *nightly(('>&-', 0, ''))])
def test_an_output_that_cannot_be_written_is_no_traceback(output, code, said):
    done = subprocess.run(['sh', '-c', f'exec "$0" -c "$1" {output}', sys.executable, PLAYED], stderr=subprocess.PIPE,
                          text=True, check=False)
    assert (done.returncode, done.stderr) == (code, said)
