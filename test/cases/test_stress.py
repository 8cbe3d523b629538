"""Attacks on the nodes, a little of each; ./run stress has the full campaign."""
import sys

import pytest

from collection.kinds import REPOSITORY

pytestmark = [pytest.mark.stress, pytest.mark.nightly]
SUITES = 'soak', 'web', 'interrupts'


@pytest.mark.parametrize('suite', SUITES, ids='stress/{}'.format)
def test_stress(suite, run_case, case_folder):
    run_case(sys.executable, REPOSITORY / 'tools' / 'bench' / 'campaign.py', suite, '--small', '--seed', '1',
             '--json', case_folder / 'figures.json')
