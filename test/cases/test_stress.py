"""Attacks on the nodes, a little of each; ./run stress has the full campaign."""
import os
import sys

import pytest

from collection.kinds import REPOSITORY

SUITES = 'soak', 'web', 'interrupts'


@pytest.mark.nightly
@pytest.mark.parametrize('suite', SUITES)
def test_stress(suite, run_case, case_folder):
    run_case(sys.executable, REPOSITORY / 'stress' / 'campaign.py', suite, '--small', '--seed', '1',
             '--json', case_folder / 'figures.json',
             PYTHONPATH=f'{REPOSITORY / "bench"}:{os.environ.get("PYTHONPATH", "")}')
