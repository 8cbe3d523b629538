"""Attacks on the nodes, a little of each; ./run stress has the full campaign."""
import os
import sys

import pytest

from collection.kinds import REPOSITORY

SUITES = 'web', 'interrupts'
LONG_SUITES = 'soak',


@pytest.mark.parametrize('suite', [*(pytest.param(suite, marks=pytest.mark.release) for suite in LONG_SUITES), *SUITES])
def test_stress(suite, run_case, case_folder):
    run_case(sys.executable, REPOSITORY / 'stress' / 'stress.py', suite, '--small', '--seed', '1',
             '--json', case_folder / 'figures.json',
             PYTHONPATH=f'{REPOSITORY / "bench"}:{os.environ.get("PYTHONPATH", "")}')
