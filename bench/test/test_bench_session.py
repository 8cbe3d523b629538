"""Commands and options of the bench, and that its suites are sound; no ROS is needed."""
import pytest

import bench
import session
import suite_turtlesim
from processes import BenchError


def _absent(_path):
    raise FileNotFoundError


@pytest.mark.parametrize('marker, inherited, expected', [
    (lambda _path: '/peer/src', '/ours', '/peer/src:/ours'),  # a devel space names its sources
    (lambda _path: '/a/src;/b/src', '/ours', '/a/src:/b/src:/ours'),
    (lambda _path: '', '/ours', '/peer/devel/share:/ours'),  # an install space has none
    (lambda _path: '/peer/src', '', '/peer/src'),
    (_absent, '/ours', '/ours'),  # no catkin workspace
])
def test_package_path(marker, inherited, expected):
    assert session.package_path('/peer/devel/lib/turtlesim/turtlesim_node', inherited, marker) == expected


def test_split_command():
    assert session.split_command("a 'b c' d") == ['a', 'b c', 'd']
    for text in ('', '   ', "a 'b"):
        with pytest.raises(BenchError):
            session.split_command(text)


def test_defaults():
    options, suite = bench.parse([])
    assert suite is suite_turtlesim
    assert options.rounds == bench.ROUNDS
    assert options.json.endswith('output/bench.json')
    assert bench.parse(['--quick'])[0].rounds == 1
    assert bench.parse(['--quick', '--rounds', '4'])[0].rounds == 4


@pytest.mark.parametrize('arguments, told', [
    (['absent'], 'turtlesim'),
    (['--rounds', '0'], '--rounds'),
    (['--only', 'rates'], 'it must be one of start, rate'),
])
def test_wrong_usage(arguments, told, capsys):
    with pytest.raises(SystemExit) as ended:
        bench.parse(arguments)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_figures_have_names_of_their_own():
    names = [figure.name for figure in suite_turtlesim.FIGURES]
    assert len(set(names)) == len(names)


class _Failing:
    side = 'ours'


def test_a_failure_stops_that_measurement_and_no_other():
    calls = []

    def fails(_subject, _scale):
        calls.append('fails')
        raise BenchError('it does not come up\nlast line')

    class Suite:
        QUICK = FULL = None
        MEASUREMENTS = {'fails': suite_turtlesim.Measurement(fails, ''),
                        'works': suite_turtlesim.Measurement(lambda _subject, _scale: {'key': [1.0]}, '')}
    options, _ = bench.parse(['--rounds', '2'])
    pools, failures = bench.measure(options, Suite, ['fails', 'works'], [_Failing()])
    assert calls == ['fails']  # not tried again in the second round
    assert pools == {'ours': {'key': [1.0, 1.0]}}
    assert failures == [('fails', 'ours', 1, 'it does not come up\nlast line')]
