"""course_grader.attempt.load: whose fault it is if time passes slowly."""
import pytest

from course_grader.attempt import load


@pytest.mark.parametrize('used, wall, expected', [
    (0.5, 0.2, False), (1.0, 0.0, False), (26.0, 25.0, False), (50.0, 25.0, True), (8.0, 4.0, True)])
def test_a_program_holds_the_simulation_up_by_more_than_one_core(used, wall, expected):
    """And not by its imports, just before it is watched."""
    assert load.hogs(used, wall) is expected


@pytest.mark.parametrize('ran, waited, used, expected', [
    (4.0, 90.0, 4.0, False),  # of 100 s: on a loaded machine it got no core, whatever it would have done
    (60.0, 10.0, 60.0, True), (30.0, 60.0, 30.0, True),  # most of the time for which it had one
    (5.0, 0.0, 5.0, False), (1.0, 10.0, 60.0, True)])  # undisturbed; in threads that have ended, one for each call
def test_a_simulator_is_flooded_if_it_is_busy_and_not_if_it_waits(ran, waited, used, expected):
    assert load.flooded({'7': (1.0, 2.0)}, {'7': (1.0 + ran, 2.0 + waited)}, 100.0, used) is expected


@pytest.mark.parametrize('used, flooded', [(2.0, False), (4.0, True)])
def test_threads_of_calls_that_have_ended_flood_a_simulator_too(used, flooded):
    assert load.flooded({}, {'1': (1.5, 4.0), '2': (0.1, 9.0)}, 10.0, used) is flooded
    assert load.flooded({}, {}, 10.0, used) is False  # the simulator has ended


@pytest.mark.parametrize('used, served, late, greedy, text', [
    (10.0, 8.0, True, False, None),  # of 200 s: the machine
    (110.0, 8.0, True, False, 'the program took 110 s of processor time in 200 s'),
    (110.0, 8.0, False, False, None),  # in real time, where the limit was not met, a busy loop may take a core
    (300.0, 8.0, False, False, 'the program took 300 s of processor time in 200 s'),
    (10.0, 70.0, True, False, 'the program kept master, simulator and grader busy, for 70 s of processor time in 200'),
    (10.0, 70.0, False, False, None),
    (10.0, 8.0, False, True, 'the program kept 8 or more threads busy'),
])
def test_who_takes_the_time_is_named(used, served, late, greedy, text):
    problem = load.hog(used, served, 200.0, late, greedy)
    assert problem.text.startswith(text) if text else problem is None
