"""sim_ros.frame_services: the calls that a step answers, their order, and calls that it does not wait for."""
import threading
import time
from types import SimpleNamespace

import pytest
import rospy

from sim_ros.frame_services import FrameServices

SOON = 10.0  # [s] deadline of what takes milliseconds, on a busy machine
MOMENT = 0.05  # [s] of looking that something does not happen


class Call:
    """A request, and its answer: ['answer', response] or ['fail', text]."""

    def __init__(self, name, log, caller='/client', service='/service'):
        self.name, self._log = name, log
        self.request = SimpleNamespace(_connection_header={'callerid': caller}, name=name)
        self.service = SimpleNamespace(resolved_name=service)

    def answer(self, response):
        self._log.append(('answer', self.name, response))

    def fail(self, text):
        self._log.append(('fail', self.name, text))


class Master:
    """A master that answers on command."""

    def __init__(self):
        self.asked, self.answers = threading.Event(), threading.Event()

    def ask(self):
        self.asked.set()
        assert self.answers.wait(SOON)
        return 'known'


@pytest.fixture
def log():
    return []


@pytest.fixture
def services():
    return FrameServices()


@pytest.fixture
def master():
    return Master()


def double(request):
    return 2 * request.name


def asking(master):
    def handler(request):
        answer = yield master.ask
        return f'{request.name} {answer}'
    return handler


def answer_until(services, condition):
    """Make steps until a condition holds."""
    end = time.monotonic() + SOON
    while not condition():
        assert time.monotonic() < end
        services.answer()


def test_nothing_is_answered_before_the_step_and_all_in_the_order_of_coming_then(services, log):
    for name in 'bac':
        services.put(Call(name, log), double)
    assert log == []
    services.answer()
    assert log == [('answer', name, 2 * name) for name in 'bac']
    services.answer()
    assert len(log) == 3


def test_what_comes_while_a_step_answers_waits_for_the_next(services, log):
    def handler(request):
        if request.name == 'a':
            services.put(Call('b', log), handler)
        return request.name
    services.put(Call('a', log), handler)
    services.answer()
    assert log == [('answer', 'a', 'a')]
    services.answer()
    assert log[1:] == [('answer', 'b', 'b')]


def test_by_name_the_order_does_not_depend_on_that_of_coming(log):
    for order in ((0, 1, 2, 3), (3, 1, 0, 2), (2, 3, 1, 0)):
        services, log = FrameServices(by_name=True), []
        calls = [Call('a', log, '/one', '/pen'), Call('b', log, '/one', '/spawn'), Call('c', log, '/two', '/clear'),
                 Call('d', log, '/two', '/pen')]
        for number in order:
            services.put(calls[number], double)
        services.answer()
        assert [name for _, name, _ in log] == ['a', 'b', 'c', 'd']


def test_who_is_to_be_told_of_a_call_is_told_once_it_is_queued(log):
    told = []
    services = FrameServices(lambda: told.append(len(log)) or services.answer())
    services.put(Call('a', log), double)
    assert told == [0]
    assert log == [('answer', 'a', 'aa')]


@pytest.mark.parametrize('error, text', [
    (rospy.ServiceException('no such turtle'), 'service cannot process request: no such turtle'),
    (ZeroDivisionError('by zero'), 'error processing request: by zero'),
])
def test_a_failure_is_answered_in_rospys_words_and_harms_no_other_call(services, log, error, text):
    def fails(request):
        raise error

    def fails_later(request):
        yield lambda: None
        raise error

    def fails_there(request):
        def ask():
            raise error
        yield ask
    for name, handler in (('a', fails), ('b', double), ('c', fails_later), ('d', fails_there), ('e', double)):
        services.put(Call(name, log), handler)
    services.answer(SOON)
    assert log == [('fail', 'a', text), ('answer', 'b', 'bb'), ('fail', 'c', text), ('fail', 'd', text),
                   ('answer', 'e', 'ee')]


def test_a_handler_asks_on_another_thread_and_goes_on_in_that_of_the_step(services, log):
    threads = []

    def handler(request):
        threads.append(threading.get_ident())
        for _ in range(2):
            threads.append((yield threading.get_ident))
            threads.append(threading.get_ident())
        return 'done'
    services.put(Call('a', log), handler)
    services.answer(SOON)
    here, there = threads[0], threads[1]
    assert threads == [here, there, here, there, here]
    assert here == threading.get_ident() != there
    assert log == [('answer', 'a', 'done')]


def test_a_slow_master_holds_up_neither_the_step_nor_other_calls_but_those_that_ask_it_too(services, log, master):
    services.put(Call('slow', log), asking(master))
    services.put(Call('asks too', log), asking(master))
    services.put(Call('quick', log), double)
    services.answer()
    assert master.asked.wait(SOON)
    assert log == [('answer', 'quick', 'quickquick')]
    services.put(Call('later', log), double)
    services.answer()
    assert log[1:] == [('answer', 'later', 'laterlater')]
    master.answers.set()
    answer_until(services, lambda: len(log) == 4)
    assert log[2:] == [('answer', 'slow', 'slow known'), ('answer', 'asks too', 'asks too known')]


def test_with_a_longer_timeout_the_step_waits_for_the_master(services, log, master):
    threading.Timer(MOMENT, master.answers.set).start()
    services.put(Call('slow', log), asking(master))
    services.put(Call('quick', log), double)
    services.answer(SOON)
    assert [name for _, name, _ in log] == ['slow', 'quick']


def test_the_end_of_what_was_waited_for_is_told(log, master):
    told = threading.Event()
    services = FrameServices(told.set)
    services.put(Call('slow', log), asking(master))
    services.answer()
    told.clear()
    assert not told.wait(MOMENT)
    master.answers.set()
    assert told.wait(SOON)
    services.answer()
    assert log == [('answer', 'slow', 'slow known')]


def test_calls_of_many_threads_are_all_answered_once(log):
    services, names = FrameServices(), [str(number) for number in range(200)]

    def client(own):
        for name in own:
            services.put(Call(name, log), double)
    threads = [threading.Thread(target=client, args=(names[number::4],)) for number in range(4)]
    for thread in threads:
        thread.start()
    answer_until(services, lambda: len(log) == len(names))
    for thread in threads:
        thread.join(SOON)
    services.answer()
    assert sorted(name for _, name, _ in log) == sorted(names)
    for number in range(4):  # those of one client in their order
        own = set(names[number::4])
        assert [name for _, name, _ in log if name in own] == names[number::4]


def test_steps_wait_for_a_slow_master_once(services, log, master):
    services.put(Call('slow', log), asking(master))
    services.answer(MOMENT)
    begun = time.monotonic()
    services.answer(SOON)
    assert time.monotonic() - begun < SOON
    assert log == []
    master.answers.set()
    answer_until(services, lambda: log)


def test_what_waited_for_others_is_waited_for_in_its_turn(services, log, master):
    services.put(Call('slow', log), asking(master))
    services.put(Call('asks too', log), asking(master))
    services.answer(0.0)
    master.answers.set()
    end = time.monotonic() + SOON
    while not log:
        assert time.monotonic() < end
        services.answer(SOON)
    assert [name for _, name, _ in log] == ['slow', 'asks too']


def test_calls_of_one_step_are_one_batch(log):
    services = FrameServices()
    seen = []
    for name in (1, 2):
        services.put(Call(name, log), lambda _: seen.append(services.batch))
    services.answer()
    services.put(Call(3, log), lambda _: seen.append(services.batch))
    services.answer()
    assert seen == [1, 1, 2]
