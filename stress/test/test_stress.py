"""Options, seeds, verdicts and the table of the campaign; no ROS master is needed."""
import json
import random
from types import SimpleNamespace

import pytest

import stress
from figures import Figure, Target, judge
from processes import BenchError
from trial import Attack, Scale, losses


def test_defaults():
    options = stress.parse([])
    assert options.suites == ['fuzz', 'clients', 'master', 'storms', 'system', 'web', 'interrupts']
    assert 0 <= options.seed <= stress.LARGEST_SEED
    assert stress.parse(['soak']).suites == ['soak']
    assert stress.parse(['--seed', '7']).seed == 7


@pytest.mark.parametrize('arguments, told', [
    (['absent'], 'the suites are fuzz'),
    (['--minutes', '0'], '--minutes'),
    (['--minutes', 'nan'], '--minutes'),
    (['--seed', '-1'], 'it must be 0 to'),
    (['--small', '--minutes', '3'], 'leave out --minutes'),
    (['fuzz', '--only', 'absent'], 'it must be one of services'),
])
def test_wrong_usage(arguments, told, capsys):
    with pytest.raises(SystemExit) as ended:
        stress.parse(arguments)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_minutes_scale_a_suite():
    assert stress.scale_of(stress.parse(['soak', '--minutes', '30']), 'soak').seconds(3600.0, 1.0) == 1800.0
    assert stress.scale_of(stress.parse(['master', '--minutes', '12']), 'master').count(50, 1) == 100
    assert stress.scale_of(stress.parse(['--small']), 'fuzz') == Scale(1.0, True)
    assert Scale(1.0, True).count(50, 2) == 2
    assert Scale(0.001).count(50, 2) == 1


def test_seeds_are_of_an_attack_alone():
    def first(*what):
        return stress.numbers(*what).random()
    assert first(1, 'fuzz', 'topics') == first(1, 'fuzz', 'topics')
    assert len({first(1, 'fuzz', 'topics'), first(2, 'fuzz', 'topics'), first(1, 'fuzz', 'tcpros')}) == 3


@pytest.mark.parametrize('suite', stress.SUITES)
def test_suites_are_sound(suite):
    module = stress.load(suite)
    names = [figure.name for figure in module.FIGURES]
    assert len(set(names)) == len(names)
    assert all(isinstance(attack, Attack) and attack.about for attack in module.ATTACKS.values())


def test_names_of_attacks_are_unique():
    names = [name for suite in stress.SUITES for name in stress.load(suite).ATTACKS]
    assert len(set(names)) == len(names)


def test_small_form_does_not_judge_the_machine():
    full = {figure.key: figure.target for figure in stress.figures_of(stress.parse(['clients']))}
    small = {figure.key: figure.target for figure in stress.figures_of(stress.parse(['clients', '--small']))}
    assert full['unread_rate_50'] is not None and small['unread_rate_50'] is None
    assert full['unread_hung'] == small['unread_hung'] == Target('at_most', 0)


def rows(*ours):
    figures = [Figure(str(number), str(number), '', sum, Target('at_most', 0)) for number in range(len(ours))]
    return [judge(figure, {'ours': {figure.key: [value]} if value is not None else {}})
            for figure, value in zip(figures, ours)]


@pytest.mark.parametrize('values, failures, lost', [
    ((0, 0), [], False),
    ((0, 1), [], True),
    ((0, None), [], False),
    ((0,), [('fuzz', 'topics', 'ours', 'why')], True),
    ((0,), [('fuzz', 'topics', 'peer', 'why')], False),  # what a peer does not survive is not ours
])
def test_what_is_lost(values, failures, lost):
    assert stress.is_lost(rows(*values), failures) is lost


def run_with(monkeypatch, tmp_path, run, arguments=()):
    """The exit code of a run of one attack, and its JSON."""
    module = SimpleNamespace(ATTACKS={'one': Attack(run, 'about')}, FIGURES=tuple(losses('one', 'words')))
    monkeypatch.setattr(stress, 'load', lambda _suite: module)
    monkeypatch.setattr(stress, '_new_master', lambda _subject: None)
    monkeypatch.setattr(stress, 'subjects', lambda _options, _folder: [SimpleNamespace(side='ours')])
    file = tmp_path / 'figures.json'
    options = stress.parse(['fuzz', '--seed', '5', '--json', str(file), *arguments])
    return stress.run(options), json.loads(file.read_text())


def test_nothing_lost(monkeypatch, tmp_path, capsys):
    code, document = run_with(monkeypatch, tmp_path, lambda *_: {'one_inputs': [3], 'one_hung': [0]})
    assert code == 0
    assert document['settings']['seed'] == 5
    told = capsys.readouterr().out
    assert '--seed 5' in told and 'words: never answered' in told


def test_something_lost(monkeypatch, tmp_path):
    assert run_with(monkeypatch, tmp_path, lambda *_: {'one_hung': [1]})[0] == 1


def test_what_could_not_be_tried_is_told(monkeypatch, tmp_path, capsys):
    def fail(*_):
        raise BenchError('the node did not come up')
    code, document = run_with(monkeypatch, tmp_path, fail)
    assert code == 1
    assert document['failures'][0]['error'] == 'BenchError in fail: the node did not come up'
    assert 'the node did not come up' in capsys.readouterr().out


def test_the_same_numbers_for_all(monkeypatch, tmp_path):
    drawn = []
    for _ in range(2):
        run_with(monkeypatch, tmp_path, lambda _subject, _scale, rng: drawn.append(rng.random()) or {'one_hung': [0]})
    assert drawn[0] == drawn[1] == random.Random('5/fuzz/one').random()


def test_an_interrupted_run_tells_what_there_is(monkeypatch, tmp_path, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt
    module = SimpleNamespace(ATTACKS={'one': Attack(lambda *_: {'one_hung': [0]}, 'about'),
                                      'two': Attack(interrupted, 'about')}, FIGURES=tuple(losses('one', 'words')))
    monkeypatch.setattr(stress, 'load', lambda _suite: module)
    monkeypatch.setattr(stress, '_new_master', lambda _subject: None)
    monkeypatch.setattr(stress, 'subjects', lambda _options, _folder: [SimpleNamespace(side='ours')])
    with pytest.raises(KeyboardInterrupt):
        stress.run(stress.parse(['fuzz', '--seed', '5']))
    assert 'words: never answered' in capsys.readouterr().out
