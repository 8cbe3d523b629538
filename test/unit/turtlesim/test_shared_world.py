"""turtlesim.shared_world: when a change returns, what a refusal does, and that pictures are of one moment."""
import threading
import time

import pytest
import rospy

from kinematic_core.turtle_world import ARENA_SIZE, BACKGROUND
from turtlesim import shared_world
from turtlesim.shared_world import SharedWorld

CENTRE = ARENA_SIZE / 2.0
AT_ONCE = 5.0  # [s] deadline of what shall happen without waiting, on a busy machine
NOT_YET = 0.05  # [s] of looking that something does not happen
T = 'turtle1'


@pytest.fixture
def shared():
    return SharedWorld(BACKGROUND)


@pytest.fixture
def errors(monkeypatch):
    logged = []
    monkeypatch.setattr(rospy, 'logerr', lambda text, *values: logged.append(text % values))
    return logged


class Teleport(threading.Thread):
    """A service call in a thread of its own, as rospy makes it."""

    def __init__(self, shared, x=2.0):
        super().__init__(daemon=True)
        self.shared, self.x = shared, x
        before = len(shared._waiting)
        self.start()
        deadline = time.monotonic() + AT_ONCE
        while len(shared._waiting) == before and time.monotonic() < deadline:
            time.sleep(0.001)
        assert len(shared._waiting) == before + 1

    def run(self):
        with self.shared.change(effect_in_step=True) as world:
            world.teleport_absolute(T, self.x, 2.0, 0.0)

    def returned(self, within):
        self.join(within)
        return not self.is_alive()


def test_change_without_effect_in_a_step_returns_at_once_with_the_lock_free(shared):
    begun = time.monotonic()
    with shared.change() as world:
        assert world is shared.world
        assert shared.lock.locked()
    assert time.monotonic() - begun < shared_world.SHUTDOWN_POLL / 2.0
    assert not shared.lock.locked()
    assert shared._waiting == []


def test_change_with_effect_in_a_step_returns_after_the_step_is_published_and_not_before(shared):
    call = Teleport(shared)
    assert not call.returned(NOT_YET)
    assert not shared.lock.locked()
    ((turtle, _, _),) = shared.step()
    assert turtle.x == 2.0
    assert not call.returned(NOT_YET)
    shared.published()
    assert call.returned(AT_ONCE)


def test_change_after_the_step_waits_for_the_next_one(shared):
    first = Teleport(shared, 2.0)
    shared.step()
    second = Teleport(shared, 3.0)
    shared.published()
    assert first.returned(AT_ONCE)
    assert not second.returned(NOT_YET)
    shared.step()
    shared.published()
    assert second.returned(AT_ONCE)
    assert shared.world.turtles[T].x == 3.0


def test_changes_of_one_step_all_return(shared):
    calls = [Teleport(shared, x) for x in (1.0, 2.0, 3.0)]
    shared.step()
    shared.published()
    assert all(call.returned(AT_ONCE) for call in calls)
    assert shared.world.turtles[T].x == 3.0


def test_publishing_nothing_and_a_step_that_was_not_published_do_no_harm(shared):
    shared.published()
    shared.step()
    call = Teleport(shared)
    shared.step()
    shared.published()
    assert call.returned(AT_ONCE)


def test_change_waiting_for_a_step_goes_on_while_the_node_lives_and_returns_at_shutdown(shared, monkeypatch):
    ended = threading.Event()
    monkeypatch.setattr(shared_world, 'SHUTDOWN_POLL', 0.01)
    monkeypatch.setattr(rospy, 'is_shutdown', ended.is_set)
    call = Teleport(shared)
    assert not call.returned(NOT_YET)
    ended.set()
    assert call.returned(AT_ONCE)


@pytest.mark.parametrize('effect_in_step', [False, True])
def test_refusal_fails_the_service_call_with_its_text_and_frees_the_lock(shared, errors, effect_in_step):
    with pytest.raises(rospy.ServiceException) as failure:
        with shared.change(effect_in_step) as world:
            world.teleport_absolute(T, float('nan'), 0.0, 0.0)
    text = 'teleport_absolute of turtle1: x is nan; it must be a finite number'
    assert str(failure.value) == text
    assert errors == [text]
    assert not shared.lock.locked()
    assert shared._waiting == []  # nobody waits for it
    shared.step()
    assert shared.world.turtles[T].x == CENTRE


def test_a_percent_sign_in_a_refusal_is_no_format(shared, errors):
    with pytest.raises(rospy.ServiceException, match='100%d'):
        with shared.change() as world:
            world.kill('100%d')
    assert 'Tried to kill turtle [100%d]' in errors[0]


def test_another_failure_passes_through_and_frees_the_lock(shared, errors):
    with pytest.raises(ZeroDivisionError):
        with shared.change(effect_in_step=True):
            raise ZeroDivisionError
    assert not shared.lock.locked()
    assert shared._waiting == []
    assert errors == []


def test_picture_is_a_copy_of_the_canvas_and_of_every_turtle_in_alphabetical_order(shared):
    with shared.change() as world:
        world.spawn(1.0, 2.0, 0.5, 'a')
    pixels, turtles = shared.picture()
    assert pixels == bytes(BACKGROUND) * (500 * 500)
    (a, first) = turtles
    assert a == ('a', 1.0, pytest.approx(ARENA_SIZE - 2.0), 0.5)
    assert first == (T, CENTRE, CENTRE, 0.0)
    before = bytes(pixels), list(turtles)
    with shared.lock:
        shared.world.teleport_absolute(T, 9.0, 9.0, 1.0)
    shared.step()
    assert (pixels, turtles) == before
    assert shared.picture() != before


@pytest.mark.parametrize('action', ['picture', 'step'])
def test_picture_and_step_wait_for_the_lock(shared, action):
    thread = threading.Thread(target=getattr(shared, action), daemon=True)
    with shared.lock:
        thread.start()
        thread.join(NOT_YET)
        assert thread.is_alive()
        assert shared.world.steps == 0
    thread.join(AT_ONCE)
    assert not thread.is_alive()
    assert not shared.lock.locked()


def test_background_is_the_one_asked_for():
    assert SharedWorld((1, 2, 3)).picture()[0] == bytes((1, 2, 3)) * (500 * 500)
