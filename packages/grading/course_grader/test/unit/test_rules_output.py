"""course_grader.rules.rules_output: topics, lines and goals."""
import pytest

from course_grader.rules.observation import Goal, Observed, OutputLine
from course_grader.rules.rules_output import Connects, Prints, Reaches


@pytest.mark.parametrize('types, seen', [
    ({'/person': 'topic_demo/Person'}, 'yes'), ({'/person': 'std_msgs/String'}, 'its type is std_msgs/String'),
    ({'/person': 'a/Personal'}, 'its type is a/Personal'), ({}, 'its type is unknown')])
def test_the_type_of_a_topic(types, seen):
    observed = Observed(connections={('/person', 'publishes')}, types=types)
    result = Connects('/person', 'publishes', 'Person').judge(observed)
    assert (result.share, result.seen) == (float(seen == 'yes'), seen)
    assert Connects('/person', 'publishes').judge(observed).share == 1.0


def test_the_level_of_a_line():
    observed = Observed(lines=[OutputLine(1.0, 'x = 8.5 m', 'WARN'), OutputLine(2.0, 'x = 8.7 m'),
                               OutputLine(3.0, 'x = 9.5 m', 'INFO')])
    assert Prints(r'\d').judge(observed).seen.startswith('3 of 3 lines')
    assert Prints(r'\d', level='WARN').judge(observed).seen.startswith('1 of 3')
    assert Prints(r'\d', level='ERROR').judge(observed).share == 0.0


@pytest.mark.parametrize('wrong, share', [(2, 1.0), (3, 0.0)])  # two may be at the limit
def test_lines_of_a_level_with_what_belongs_to_another(wrong, share):
    lines = [OutputLine(0.0, f'x is {x}', 'INFO') for x in ['6.5'] * 3 + ['8.1'] * wrong]
    lines += [OutputLine(0.0, 'x is 8.1', 'WARN')] * 9
    got = Prints(r'\b[67]\.', times=3, level='INFO', without=r'\b8\.').judge(Observed(lines=lines))
    assert got.share == share and ("others do not belong there, such as 'x is 8.1'" in got.seen) == (not share)


FIVE = Goal(0.0, '/fibonacci', 5, False, 'SUCCEEDED', 4, (0, 1, 1, 2, 3, 5))  # 4 of 6 numbers are computed
CANCELLED = Goal(9.0, '/fibonacci', 40, True, 'PREEMPTED', 2, (0, 1, 1, 2))


@pytest.mark.parametrize('goals, share, said', [
    ([FIVE, CANCELLED], 1.0, '2 of 2 goals'),
    ([FIVE._replace(state='ABORTED'), CANCELLED], 0.245, '1 of 2 goals; the goal of order 5 is ABORTED'),
    ([FIVE._replace(result=(0, 1, 1, 2, 3))], 0.0, 'order 5 is [0, 1, 1, 2, 3], expected [0, 1, 1, 2, 3, 5]'),
    ([FIVE._replace(feedback=3)], 0.0, '3 messages of feedback for 4 numbers'),
    ([CANCELLED._replace(state='SUCCEEDED')], 0.0, 'the cancelled goal is SUCCEEDED, not PREEMPTED'),
    ([FIVE._replace(action='/other')], 0.0, 'the program never offered it'),
    ([FIVE], 0.245, '1 of 2 goals; the time was over before the last goal'),
])
def test_goals_of_an_action(goals, share, said):
    result = Reaches('/fibonacci').judge(Observed(goals=goals))
    assert result.share == pytest.approx(share) and said in result.seen
