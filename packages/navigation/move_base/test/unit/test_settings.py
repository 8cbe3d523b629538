"""move_base.settings: parameters that public packages give to the planners, and those that are refused."""
import pytest
import rospy

from move_base import settings
from rospy_support.parameters import Parameter, ParameterError


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


@pytest.mark.parametrize('read, name, value, said', [
    (settings.planner, 'base_local_planner', 'teb_local_planner/TebLocalPlannerROS', 'one of base_local_planner/Traj'),
    (settings.planner, 'TrajectoryPlannerROS/y_vels', 'fast', 'it must be a list of speeds'),
    (settings.planner, 'TrajectoryPlannerROS/max_vel_x', 0.0, 'it must be more than 0, or the robot cannot drive'),
    (lambda: settings.footprint('global_costmap'), 'global_costmap/footprint', [[0, 0], [1, 1]],
     'at least three corners'),
    (lambda: settings.layers('local_costmap'), 'local_costmap/plugins', [{'name': 'a', 'type': 'x::Layer'}],
     'one of costmap_2d::StaticLayer'),
    (lambda: settings.layers('local_costmap'), 'local_costmap/plugins', 'static', 'it must be a list such as')])
def test_wrong_parameters_are_refused_with_what_is_allowed(monkeypatch, read, name, value, said):
    monkeypatch.setattr(rospy, 'get_param', lambda key, default=None: value if key == f'~{name}' else default)
    monkeypatch.setattr(rospy, 'resolve_name', lambda key: key)
    with pytest.raises(ParameterError) as refused:
        read()
    assert said in str(refused.value)
