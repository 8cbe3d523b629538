"""The order of messages to a client, and the messages that are dropped."""
import pytest

from browser_servers.core.outbox import BURST, BURST_BYTES, LATEST, MAX_ANSWERS, PATIENCE, SMALL, Full, Outbox

LARGE = SMALL + 1


def box(*topics, period=0.0, length=0):
    outbox = Outbox()
    for topic in topics:
        outbox.configure(topic, period, length)
    return outbox


def taken(outbox, now=0.0):
    items = []
    while True:
        item = outbox.take(now)
        if item is None:
            return items
        items.append(item)


def test_answers_then_small_then_large():
    outbox = box('image', 'pose')
    outbox.put('image', 'image', LARGE, 0.0)
    outbox.put('pose', 'pose', 10, 0.1)
    outbox.answer('answer', 10)
    assert taken(outbox, 0.1) == ['answer', 'pose', 'image']


def test_small_messages_keep_the_order_of_arrival_over_topics():
    outbox = box('a', 'b')
    for number, topic in enumerate('abab'):
        outbox.put(topic, f'{topic}{number}', 10, number / 1000)
    assert taken(outbox) == ['a0', 'b1', 'a2', 'b3']


def test_large_message_comes_after_its_patience():
    outbox = box('image', 'pose')
    outbox.put('image', 'image', LARGE, 0.0)
    outbox.put('pose', 'pose', 10, PATIENCE)
    assert outbox.take(PATIENCE) == 'image'


def test_only_the_newest_large_message_waits():
    outbox = box('image')
    for number in range(5):
        outbox.put('image', number, LARGE, number)
    assert taken(outbox, 5.0) == [4]


def test_burst_passes_whole_and_late_messages_give_way():
    outbox = box('tf')
    for number in range(10):
        outbox.put('tf', number, 10, 0.0)
    assert taken(outbox, LATEST / 2) == list(range(10))
    for number in range(10):
        outbox.put('tf', number, 10, number * LATEST)  # the client took nothing for a second
    assert taken(outbox, 9.5 * LATEST) == [9]


def test_latched_messages_are_kept_however_late():
    outbox = box('tf_static')
    for number in range(3):
        outbox.put('tf_static', number, LARGE, 0.0, kept=True)
    assert taken(outbox, 100.0) == [0, 1, 2]


def test_queue_length_of_the_client_counts():
    outbox = box('a', length=3)
    for number in range(10):
        outbox.put('a', number, 10, 0.0)
    assert taken(outbox, 100.0) == [7, 8, 9]


def test_throttled_topic_sends_the_newest_once_a_period():
    outbox = box('pose', period=0.1)
    sent = []
    for tick in range(100):  # 1 s at 100 Hz
        outbox.put('pose', tick, 10, tick / 100)
        sent += taken(outbox, tick / 100)
    assert len(sent) == 10 and sent[0] == 0 and sent == sorted(sent)
    assert outbox.next_due() == pytest.approx(1.0, abs=0.1)
    assert taken(outbox, 1.1) == [99]  # the last one is not lost


def test_throttle_of_one_topic_delays_no_other():
    outbox = box('slow', period=10.0)
    outbox.configure('fast', 0.0, 0)
    for topic in ('slow', 'fast', 'slow', 'fast'):
        outbox.put(topic, topic, 10, 0.0)
    assert sorted(taken(outbox)) == ['fast', 'fast', 'slow']


def test_memory_is_bounded_whatever_comes():
    outbox = box('a', 'b')
    for number in range(100000):
        outbox.put('a', number, 100, number)
        outbox.put('b', number, SMALL, number)
    assert len([1 for item in taken(outbox, 0.0) if item is not None]) <= 2 * BURST
    for number in range(1000):
        outbox.put('b', number, SMALL, 0.0)
    assert SMALL * len(taken(outbox, 0.0)) <= BURST_BYTES


def test_answers_are_bounded():
    outbox = Outbox()
    outbox.answer('one', MAX_ANSWERS)
    with pytest.raises(Full):
        outbox.answer('two', 1)
    assert outbox.take(0.0) == 'one'
    outbox.answer('three', MAX_ANSWERS + 1)  # a single one may have any size


def test_topic_that_nobody_wants_is_dropped():
    outbox = box('a')
    outbox.put('a', 1, 10, 0.0)
    outbox.forget('a')
    outbox.put('a', 2, 10, 0.0)
    assert outbox.next_due() is None and outbox.take(0.0) is None
