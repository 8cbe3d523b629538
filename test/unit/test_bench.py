"""./run bench: suites, options, judgement and table; a probe that fails tells why. Nothing is measured."""
import json
import sys

import pytest

import figures
import measure
from figures import Figure, Target, median, p95, rate_in_window
from processes import BenchError, Child, stop_all
from session import Measurement, answer, package_path

POOLS = {'ours': {'fast': [1.0], 'slow': [0.7], 'plain': [3.0]}, 'peer': {'fast': [1.0]}}
FIGURES = (Figure('fast', 'fast', 'ms', median, Target('ratio', 1.5)),
           Figure('slow', 'slow', 's', median, Target('below', 0.6)), Figure('plain', 'plain', 'MB'),
           Figure('absent', 'absent', 's', median, Target('near', 62.5)))
PROBE = 'import sys; print("talks", flush=True); sys.exit("no pose")'


@pytest.mark.parametrize('name', measure.suites())
def test_suite_describes_its_measurements_and_figures(name):
    suite = measure.parse([name])[1]
    names = [figure.name for figure in suite.FIGURES]
    assert suite.MEASUREMENTS and len(set(names)) == len(names) and suite.__doc__


@pytest.mark.parametrize('arguments, told', [
    (['--rounds', '0'], '--rounds'), (['--only', 'rates'], 'it must be one of start, rate'),
    (['turtlesim', 'frames'], 'folder is only for ./run bench markers and programs'),
    (['markers', '/nonexistent'], 'no frames with ground truth'), (['markers', '--peer', 'x'], 'measures no node'),
    (['programs', '/nonexistent'], 'is not a folder'),
    (['navigation', '--peer', '/nonexistent'], 'there is no built catkin workspace'),
])
def test_wrong_usage(arguments, told, capsys):
    with pytest.raises(SystemExit) as ended:
        measure.parse(arguments)
    assert ended.value.code == 2 and told in capsys.readouterr().err


@pytest.mark.parametrize('kind, limit, ours, ratio, expected', [
    ('ratio', 1.05, 9.0, 1.05, True), ('ratio', 1.05, 9.0, 1.051, False), ('ratio', 1.05, 9.0, None, None),
    ('times', 2.0, 9.0, 1.99, False), ('below', 0.6, 0.6, None, False), ('below', 0.6, None, None, None),
    ('at_least', 150000.0, 150000.0, None, True), ('at_most', 0, 1, None, False),
    ('near', 62.5, 62.2, None, True), ('near', 62.5, 63.0, None, False),  # 0.48 % below, 0.8 % above
])
def test_target(kind, limit, ours, ratio, expected):
    assert Target(kind, limit).reached(ours, ratio) is expected


@pytest.mark.parametrize('stamps, expected', [
    ([0.1 * tick + 0.01 for tick in range(10)], 10.0),  # 9 intervals of 0.1 s; 10 in 1 s is right by luck
    ([0.0, 0.1, 0.2, 0.3], 3 / 0.8),  # stalled after 0.3 s: 3 intervals in 1 s less the edge of 0.2 s
    ([0.5], 0.0),
])
def test_rates_and_percentiles(stamps, expected):
    assert rate_in_window(stamps, 1.0, 0.2) == pytest.approx(expected)
    assert p95([1.0, 2.0, 3.0, 4.0]) == pytest.approx(3.85)  # 1 + 0.95 * 3


def test_table_sentence_and_json():
    rows = [figures.judge(figure, POOLS) for figure in FIGURES]
    assert figures.table(rows).splitlines()[2:] == [
        'fast [ms]      1     1   1.00  <= 1.5 x peer  yes', 'slow [s]     0.7     -      -  < 0.6          NO',
        'plain [MB]     3     -      -']
    assert figures.verdict(rows) == ('1 of 3 targets reached, 1 missed (slow), '
                                     '1 not judged (not measured, or a ratio without --peer).')
    options, _ = measure.parse([])
    first, *_ = json.loads(measure.as_json(options, rows, [], {}))['figures']
    assert (first['ratio'], first['ok'], first['ours']) == (1.0, True, 1.0)


def test_a_failure_stops_that_measurement_and_no_other():
    def fails(*_):
        raise BenchError('it does not come up\nlast line')

    class Suite:
        QUICK = FULL = None
        MEASUREMENTS = {'fails': Measurement(fails, ''), 'works': Measurement(lambda *_: {'key': [1.0]}, '')}
    options, _ = measure.parse(['--rounds', '2'])
    pools, failures = measure.measure(options, Suite, list(Suite.MEASUREMENTS), [type('Subject', (), {'side': 'ours'})])
    assert pools == {'ours': {'key': [1.0, 1.0]}}
    assert failures == ['Not measured: fails of ours in round 1. it does not come up\nlast line']  # not tried again


def test_a_probe_that_gives_up_says_why_and_nothing_is_left(tmp_path):
    node = Child('node', [sys.executable, '-c', 'import time; time.sleep(60)'], None, str(tmp_path))
    with Child('probe', [sys.executable, '-c', PROBE], None, str(tmp_path), lines=True) as probe:
        with pytest.raises(BenchError, match="printed 'talks', expected JSON"):
            answer(probe, 0.0, node)
        with pytest.raises(BenchError, match='(?s)ended without an answer.*no pose'):
            answer(probe, 0.0, node)
    stop_all()
    assert not node.runs() and not Child.alive
    with pytest.raises(BenchError, match='cannot be started'):
        Child('node', [str(tmp_path / 'absent')], None, str(tmp_path))


@pytest.mark.parametrize('content, expected', [
    ('/a/src;/b/src', '/a/src:/b/src:/ours'), ('', 'PREFIX/share:/ours'), (None, '/ours')])
def test_a_peer_finds_the_packages_of_its_own_workspace(tmp_path, content, expected):
    if content is not None:
        (tmp_path / '.catkin').write_text(content)
    found = package_path(str(tmp_path / 'lib' / 'turtlesim' / 'turtlesim_node'), '/ours')
    assert found == expected.replace('PREFIX', str(tmp_path))
