"""Cases of parametrized tests."""
import pytest


def nightly(*cases):
    """Return the cases as nightly ones, which ./run test leaves out. A plain tuple is one of several arguments."""
    return [pytest.param(*(case if type(case) is tuple else (case,)), marks=pytest.mark.nightly) for case in cases]
