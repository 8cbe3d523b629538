"""Options, verdicts and suites of the campaign, and the memory of a node as the soak measures it. Without a master."""
import json
import mmap
import os
import tempfile
from types import SimpleNamespace

import numpy as np
import pytest

import campaign
import stress_soak
from figures import Target
from processes import BenchError
from trial import Attack, Scale, losses

SIZE = 50_000_000  # [bytes]


@pytest.mark.parametrize('arguments, told', [
    (['absent'], 'the suites are web'), (['--minutes', '0'], '--minutes'), (['--minutes', 'nan'], '--minutes'),
    (['--seed', '-1'], 'it must be 0 to'), (['--small', '--minutes', '3'], 'leave out --minutes'),
    (['web', '--only', 'absent'], 'it must be one of web_garbage'),
])
def test_wrong_usage(arguments, told, capsys):
    with pytest.raises(SystemExit) as ended:
        campaign.parse(arguments)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_minutes_scale_a_suite():
    assert campaign.scale_of(campaign.parse(['soak', '--minutes', '30']), 'soak').seconds(3600.0, 1.0) == 1800.0
    assert campaign.scale_of(campaign.parse(['--small']), 'web') == Scale(1.0, True)
    assert Scale(1.0, True).count(50, 2) == 2
    assert Scale(0.001).count(50, 2) == 1


def test_suites_are_sound():
    figures = [figure.name for suite in campaign.SUITES for figure in campaign.load(suite).FIGURES]
    attacks = [name for suite in campaign.SUITES for name in campaign.load(suite).ATTACKS]
    assert len(set(figures)) == len(figures) and len(set(attacks)) == len(attacks)


def test_small_form_does_not_judge_the_machine():
    full = {figure.key: figure.target for figure in campaign.figures_of(campaign.parse(['web']))}
    small = {figure.key: figure.target for figure in campaign.figures_of(campaign.parse(['web', '--small']))}
    assert full['web_paths_gap'] is not None and small['web_paths_gap'] is None
    assert full['web_paths_hung'] == small['web_paths_hung'] == Target('at_most', 0)


def fail(*_):
    raise BenchError('the node did not come up')


def interrupted(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize('attack, code, said', [
    (lambda *_: {'one_inputs': [3], 'one_hung': [0]}, 0, 'words: never answered'),
    (lambda *_: {'one_hung': [1]}, 1, '1 missed (words: never answered)'),
    (fail, 1, 'Not tried: web, one. BenchError in fail: the node did not come up'),
    (interrupted, None, 'The seed was 5; --seed 5 sends the same inputs.'),
])
def test_a_run(monkeypatch, tmp_path, capsys, attack, code, said):
    module = SimpleNamespace(ATTACKS={'one': Attack(attack, 'about')}, FIGURES=tuple(losses('one', 'words')))
    monkeypatch.setattr(campaign, 'load', lambda _suite: module)
    monkeypatch.setattr(campaign, '_new_master', lambda _subject: None)
    monkeypatch.setattr(campaign, 'Subject', lambda *_: None)
    file = tmp_path / 'figures.json'
    options = campaign.parse(['web', '--seed', '5', '--json', str(file)])
    if code is None:
        with pytest.raises(KeyboardInterrupt):
            campaign.run(options)
    else:
        assert campaign.run(options) == code
    assert said in capsys.readouterr().out and json.loads(file.read_text())['settings']['seed'] == 5


def test_growth_of_a_line_with_noise():
    """Its 95 % interval holds the slope of 30 a day."""
    rng = np.random.default_rng(1)
    times = np.arange(0.0, 3600.0, 5.0)
    slope, margin = stress_soak.growth(np.stack([times, 80.0 + 30.0 * times / stress_soak.DAY
                                                 + rng.normal(0.0, 0.1, len(times))], 1))
    assert 0.0 < abs(slope - 30.0) < margin < 10.0


def test_own_memory_is_what_a_process_fills():
    """And not the part of a file's pages that falls to it, which changes with what other programs do."""
    before = stress_soak.own_memory(os.getpid())
    kept = bytearray(b'x') * SIZE
    assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
    with tempfile.TemporaryFile(dir='/var/tmp') as file:  # on a disk: what lies in a tmpfs is memory
        file.write(kept)
        file.flush()
        mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        assert mapped.find(b'y') == -1  # reads all pages
        assert stress_soak.own_memory(os.getpid()) - before == pytest.approx(SIZE / 1e6, abs=2.0)
