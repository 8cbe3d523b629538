"""Bad inputs: the same seed gives the same, and none of them is legal."""
import math
import random

import inputs
import tcpros

TRIES = 2000


def drawn(make, seed, count=50):
    rng = random.Random(seed)
    return [make(rng) for _ in range(count)]


def test_the_seed_repeats():
    makers = [inputs.bad_twist, inputs.bad_frame, inputs.bad_header, inputs.bad_http,
              lambda rng: inputs.coordinates(rng, 3)]
    for make in makers:
        assert list(map(repr, drawn(make, 1))) == list(map(repr, drawn(make, 1)))
        assert list(map(repr, drawn(make, 1))) != list(map(repr, drawn(make, 2)))


def test_calls_of_hypothesis_repeat():
    def calls(seed):
        found = []
        inputs.each_call(30, seed, lambda *call: found.append(repr(call)))
        return found
    assert calls(1) == calls(1) != calls(2)
    assert len(calls(1)) == 30


def test_coordinates_are_absurd():
    for seed in range(TRIES):
        values = inputs.coordinates(random.Random(seed), 3)
        assert any(not math.isfinite(value) or abs(value) > 1e6 for value in values)


def test_twists_are_absurd_where_it_counts():
    for seed in range(TRIES):
        values = inputs.TWIST.unpack(inputs.bad_twist(random.Random(seed)))
        assert any(not math.isfinite(values[place]) or abs(values[place]) > 1e6 for place in (0, 1, 5))


def test_wrong_lengths_are_wrong():
    kind, make = inputs.BAD_REQUESTS['/turtle1/teleport_absolute']
    assert kind._type == 'turtlesim/TeleportAbsolute'
    for seed in range(TRIES):
        for size in (1, 4, 8, 12, 16):
            assert len(inputs.wrong_length(random.Random(seed), b'x' * size)) != size


def test_no_frame_holds_a_twist():
    for seed in range(TRIES):
        data = inputs.bad_frame(random.Random(seed))
        assert data[:4] != tcpros.LENGTH.pack(inputs.TWIST.size)


def test_headers_end_where_they_say():
    data = tcpros.header(topic='/a', type='b')
    assert tcpros.LENGTH.unpack(data[:4])[0] == len(data) - 4
    assert data[4:] == tcpros.framed(b'topic=/a') + tcpros.framed(b'type=b')
