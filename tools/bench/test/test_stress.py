"""Options and suites of ./run stress, and the growth of a node as the soak measures it. Without a master."""
import numpy as np
import pytest

import campaign
import stress_soak
from figures import Target
from trial import Scale


@pytest.mark.parametrize('arguments, told', [
    (['absent'], 'the suites are web'), (['web', '--only', 'absent'], 'it must be one of web_garbage'),
    (['--small', '--minutes', '3'], 'not allowed with'),
])
def test_wrong_usage(arguments, told, capsys):
    with pytest.raises(SystemExit) as ended:
        campaign.parse(arguments)
    assert ended.value.code == 2 and told in capsys.readouterr().err


def test_minutes_scale_a_suite():
    assert Scale(0.5).seconds(3600.0, 1.0) == 1800.0
    assert Scale(1.0, True).count(50, 2) == 2 and Scale(0.001).count(50, 2) == 1


def test_suites_are_sound_and_the_small_form_does_not_judge_the_machine():
    full, small = (campaign.parse([*campaign.SUITES, *more])[1] for more in ([], ['--small']))
    targets = [{figure.name: figure.target for figure in suite.FIGURES} for suite in (full, small)]
    assert len(targets[0]) == len(full.FIGURES) and all(figure.required for figure in full.FIGURES)
    gap = 'broken bytes: longest time without a pose beside'
    assert targets[0][gap] is not None and targets[1][gap] is None
    assert {suite['broken bytes: never answered'] for suite in targets} == {Target('at_most', 0)}


def test_growth_of_a_line_with_noise():
    """Its 95 % interval holds the slope of 30 a day."""
    rng = np.random.default_rng(1)
    times = np.arange(0.0, 3600.0, 5.0)
    slope, margin = stress_soak.growth(np.stack([times, 80.0 + 30.0 * times / stress_soak.DAY
                                                 + rng.normal(0.0, 0.1, len(times))], 1))
    assert 0.0 < abs(slope - 30.0) < margin < 10.0
