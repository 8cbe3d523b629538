"""move_base.settings: parameters that public packages give to the planners."""
import pytest

from move_base import settings
from rospy_support.parameters import Parameter


@pytest.mark.parametrize('planner, samples', [
    (settings.DWA, {'vx_samples': 0, 'vy_samples': 0, 'vth_samples': 0}),  # turtlebot3_navigation has vy_samples 0
    (settings.TRAJECTORY, {'vx_samples': 0, 'vtheta_samples': 0})])
def test_no_samples_are_one(monkeypatch, planner, samples):
    name = planner.rpartition('/')[2]
    given = {'~base_local_planner': planner, **{f'~{name}/{key}': value for key, value in samples.items()}}
    monkeypatch.setattr(Parameter, 'read', lambda self: given.get(self.name, self.default))
    assert all(settings.PARAMETERS[key].minimum <= 0 for key in given if key.endswith('_samples'))
    read = settings.planner()[1]
    assert (read.vx_samples, read.vth_samples) == (1, 1)
    assert read.vy_samples == (1 if planner == settings.DWA else 9)  # y_vels has four speeds
