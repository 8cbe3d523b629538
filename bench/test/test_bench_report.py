"""Table, closing sentence and JSON of bench/report.py."""
import json

import pytest

import report
from figures import Figure, Target, judge, median

FAST = Figure('fast', 'fast', 'ms', median, Target('ratio', 1.5))
SLOW = Figure('slow', 'slow', 's', median, Target('below', 0.6))
PLAIN = Figure('plain', 'plain', 'MB')
POOLS = {'ours': {'fast': [1.0], 'slow': [0.7], 'plain': [3.0]}, 'peer': {'fast': [1.0]}}
ROWS = [judge(figure, POOLS) for figure in (FAST, SLOW, PLAIN)]


@pytest.mark.parametrize('value, text', [
    (None, '-'), (0.0, '0'), (0.12345, '0.1235'), (62.5, '62.5'), (123.46, '123.5'), (1234567.8, '1,234,568'),
])
def test_number(value, text):
    assert report.number(value) == text


def test_cells_tell_the_verdict():
    assert report.cells(ROWS[0]) == ('fast [ms]', '1', '1', '1.00', '<= 1.5 x peer', 'yes')
    assert report.cells(ROWS[1]) == ('slow [s]', '0.7', '-', '-', '< 0.6', 'NO')
    assert report.cells(ROWS[2]) == ('plain [MB]', '3', '-', '-', '', '')


def test_table_is_aligned_and_leaves_out_what_was_not_measured():
    lines = report.table([*ROWS, judge(Figure('absent', 'absent', 's'), POOLS)]).splitlines()
    assert len(lines) == 5  # header, rule, three rows
    ends = {line.index(' 1.00') for line in lines if ' 1.00' in line}
    assert ends == {lines[0].index('ratio')}


def test_verdict_counts():
    assert report.verdict(ROWS) == '1 of 2 targets reached, 1 missed (slow).'
    alone = [judge(FAST, {'ours': {'fast': [1.0]}})]
    assert report.verdict(alone) == '0 of 1 targets reached, 1 not judged (not measured, or a ratio without --peer).'


@pytest.mark.parametrize('cpuinfo, name', [
    ('processor\t: 0\nmodel name\t: A Processor @ 2 GHz\n', 'A Processor @ 2 GHz'),
    ('processor: 0\nBogoMIPS: 1\nModel : A Board\n', 'A Board'),
    ('', 'unknown'),
])
def test_cpu_model(cpuinfo, name):
    assert report.cpu_model(cpuinfo) == name


def test_machine_holds_no_paths():
    facts = report.machine()
    assert {'cores', 'cpu', 'python'} <= set(facts)
    assert not any('/home' in str(value) or '/usr' in str(value) for value in facts.values())


def test_json_holds_every_row():
    document = json.loads(report.as_json('turtlesim', ROWS, [], {'rounds': 1}, {'cores': 4}))
    assert [entry['key'] for entry in document['figures']] == ['fast', 'slow', 'plain']
    assert document['figures'][0]['ratio'] == 1.0
    assert document['figures'][1]['ok'] is False
    assert document['figures'][2]['target'] is None
    assert document['machine'] == {'cores': 4}


def test_figures_that_are_counts_have_no_unit():
    row = judge(Figure('lost', 'lost', '', sum, Target('at_most', 0)), {'ours': {'lost': [1, 2]}})
    assert report.cells(row) == ('lost', '3', '-', '-', '<= 0', 'NO')
