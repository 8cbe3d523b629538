"""turtlesim.shared_world: changes, refusals, and images of one moment."""
import threading

import pytest
import rospy

from kinematic_core.worlds.turtle_world import ARENA_SIZE, BACKGROUND
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


def test_change_hands_out_the_world_under_the_lock(shared):
    with shared.change() as world:
        assert world is shared.world
        assert shared.lock.locked()
    assert not shared.lock.locked()


def test_a_teleport_takes_effect_in_the_next_step(shared):
    with shared.change() as world:
        world.teleport_absolute(T, 2.0, 2.0, 0.0)
    assert shared.world.turtles[T].x == CENTRE
    ((turtle, _, _),) = shared.step()
    assert turtle.x == 2.0


def test_refusal_fails_the_service_call_with_its_text_and_frees_the_lock(shared, errors):
    with pytest.raises(rospy.ServiceException) as failure:
        with shared.change() as world:
            world.teleport_absolute(T, float('nan'), 0.0, 0.0)
    text = 'teleport_absolute of turtle1: x is nan; it must be a finite number'
    assert str(failure.value) == text
    assert errors == [text]
    assert not shared.lock.locked()
    shared.step()
    assert shared.world.turtles[T].x == CENTRE


def test_a_percent_sign_in_a_refusal_is_no_format(shared, errors):
    with pytest.raises(rospy.ServiceException, match='100%d'):
        with shared.change() as world:
            world.kill('100%d')
    assert 'Tried to kill turtle [100%d]' in errors[0]


def test_another_failure_passes_through_and_frees_the_lock(shared, errors):
    with pytest.raises(ZeroDivisionError):
        with shared.change():
            raise ZeroDivisionError
    assert not shared.lock.locked()
    assert errors == []


def test_image_is_a_copy_of_the_canvas_and_of_every_turtle_in_alphabetical_order(shared):
    with shared.change() as world:
        world.spawn(1.0, 2.0, 0.5, 'a')
    pixels, turtles = shared.image()
    assert pixels == bytes(BACKGROUND) * (500 * 500)
    (a, first) = turtles
    assert a == ('a', 1.0, pytest.approx(ARENA_SIZE - 2.0), 0.5)
    assert first == (T, CENTRE, CENTRE, 0.0)
    before = bytes(pixels), list(turtles)
    with shared.lock:
        shared.world.teleport_absolute(T, 9.0, 9.0, 1.0)
    shared.step()
    assert (pixels, turtles) == before
    assert shared.image() != before


@pytest.mark.parametrize('action', ['image', 'step'])
def test_image_and_step_wait_for_the_lock(shared, action):
    thread = threading.Thread(target=getattr(shared, action), daemon=True)
    with shared.lock:
        thread.start()
        thread.join(NOT_YET)
        assert thread.is_alive()
        assert shared.world.steps == 0
    thread.join(AT_ONCE)
    assert not thread.is_alive()
    assert not shared.lock.locked()
