"""kinematic_core.timing.pacing: pause, resume, steps and changes of the rate, in any order, from many threads."""
import itertools
import math
import threading

from hypothesis import given, settings
from hypothesis import strategies as st

from kinematic_core.timing.pacing import Pacer
from rostest_support.waiting import until

STEP = 0.016  # [s]


class Model:
    """The expected pacer, in wall time that only ``advance`` moves: the exact time until the next step."""

    def __init__(self):
        self.steps, self.requested, self.paused, self.left = 0, 0, False, STEP

    def pause(self):
        self.paused = True

    def request(self, steps):
        self.paused, self.requested = True, self.requested + steps

    def resume(self):
        self.paused, self.requested = False, 0

    def advance(self, seconds):
        self.left -= 0.0 if self.paused else seconds

    def step(self):
        """Return whether there is one to make."""
        by_hand = self.requested > 0
        in_time = not by_hand and not self.paused and self.left <= 0.0
        self.steps, self.requested = self.steps + (by_hand or in_time), self.requested - by_hand
        self.left += in_time * STEP
        return by_hand or in_time


OPERATIONS = st.lists(st.one_of(
    st.just(('pause',)), st.just(('resume',)), st.tuples(st.just('request'), st.integers(0, 3)),
    st.tuples(st.just('advance'), st.sampled_from([0.004, 0.007, 0.05])), st.just(('step',))), max_size=60)


@given(OPERATIONS)
@settings(deadline=None)
def test_any_order_of_changes_makes_the_steps_of_the_model(operations):
    now, model = [100.0], Model()
    paced = Pacer(STEP, monotonic=lambda: now[0], sleep=lambda seconds: paced.wake())
    paced.wait()
    for name, *values in operations:
        if name == 'advance':
            now[0] += values[0] + 1e-9  # so that rounding does not decide
            model.advance(values[0] + 1e-9)
        elif name == 'step':
            paced._last = -math.inf  # late steps are made up for at a limited pace, which has tests of its own
            assert (paced.wait() is not None) == model.step()
        else:
            getattr(paced, name)(*values)
            getattr(model, name)(*values)
        assert (paced.steps, paced.paused) == (model.steps, model.paused)


THREAD_OPERATIONS = st.lists(st.one_of(
    st.just(('pause',)), st.just(('resume',)), st.just(('wake',)), st.tuples(st.just('request'), st.integers(0, 3))),
    min_size=1, max_size=20)


@given(st.lists(THREAD_OPERATIONS, min_size=2, max_size=5))
@settings(deadline=None, max_examples=40)
def test_many_threads_at_once_get_what_they_ask_for(lists):
    """Every request is answered, with True only where its steps were made; then the pacer still does all it can."""
    paced, answered, ended = Pacer(0.001), [], threading.Event()

    def client(operations):
        for name, *values in operations:
            result = getattr(paced, name)(*values)
            if name in ('pause', 'request'):
                assert result.wait(10.0)
                answered.append((result.made, result.last <= paced.steps))

    def simulator():
        numbers = [0]
        while not ended.is_set():
            if paced.wait() is not None:
                numbers.append(paced.steps)
        assert numbers == list(range(len(numbers)))  # none lost, none twice
        simulated.append(len(numbers))

    simulated = []
    simulation = threading.Thread(target=simulator, daemon=True)
    clients = [threading.Thread(target=client, args=(operations,), daemon=True) for operations in lists]
    for thread in (simulation, *clients):
        thread.start()
    for thread in clients:
        thread.join(30.0)
    assert len(answered) == sum(operation[0] in ('pause', 'request') for operation in itertools.chain(*lists))
    assert {reached for made, reached in answered if made} <= {True}
    pause = paced.pause()
    assert pause.wait(10.0) and pause.made
    request = paced.request(3)
    assert request.wait(10.0) and request.made and request.last == pause.last + 3 == paced.steps
    paced.resume()
    until(lambda: paced.steps >= request.last + 3, 'steps')
    ended.set()
    paced.wake()
    simulation.join(10.0)
    assert simulated
