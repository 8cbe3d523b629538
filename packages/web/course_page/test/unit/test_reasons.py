"""course_page.reasons: the line that tells why a program has ended, found between what roslaunch always writes."""
import pytest

from course_page import reasons

ENDED = '''\x1b[31m================================REQUIRED process [{node}-3] has died!
process has died [pid 12234, exit code 1, cmd /ws/devel/lib/pkg/{node} __name:={node} __log:=/log/{node}-3.log].
log file: /log/{node}-3*.log
Initiating shutdown!
================================================================================\x1b[0m
[{node}-3] killing on exit
[robot_state_publisher-2] killing on exit
shutting down processing monitor...
... shutting down processing monitor complete
\x1b[1mdone\x1b[0m
'''
STARTED = '''... logging to /log/roslaunch-vm-12015.log
Checking log directory for disk usage. This may take a while.
\x1b]2;/ws/world.launch\x07
\x1b[1mstarted roslaunch server http://localhost:32815/\x1b[0m

SUMMARY
========

PARAMETERS
 * /robotont_gazebo/world: minimaze

NODES
  /
    robotont_gazebo (robotont_gazebo/robotont_gazebo)

\x1b[1mROS_MASTER_URI=http://localhost:11711/\x1b[0m
\x1b[1mprocess[robotont_gazebo-3]: started with pid [12234]\x1b[0m
'''
SECOND = '/robotont_gazebo does not start: a robot with the same name runs already.'


@pytest.mark.parametrize('output, expected', [
    (f'{STARTED}{SECOND}\n{ENDED.format(node="robotont_gazebo")}', SECOND),
    (f'{STARTED}{SECOND}\n[INFO] [1795861099.62]: Rate: error: 3\n{ENDED.format(node="robotont_gazebo")}', SECOND),
    (f'{STARTED}[ERROR] [1795861099.625853]: no world is called maze2\n[WARN] [1795861099.7]: late\n'
     f'{ENDED.format(node="robotont_gazebo")}', 'no world is called maze2'),
    (f'{STARTED}Traceback (most recent call last):\n  File "/x.py", line 4, in <module>\n    1 / 0\n'
     f'ZeroDivisionError: division by zero\n{ENDED.format(node="robotont_gazebo")}',
     'ZeroDivisionError: division by zero'),
    (f'{STARTED}{ENDED.format(node="camera")}', 'camera has ended with the exit code 1'),
    ('\x1b[31mRLException: [x.launch] is neither a launch file in package [nopkg] nor is it a file\x1b[0m\n'
     '\x1b[31mThe traceback for the exception was written to the log file\x1b[0m\n',
     '[x.launch] is neither a launch file in package [nopkg] nor is it a file'),
    ('no laser', 'no laser'), ('', ''), (STARTED, '')])
def test_the_reason_is_found(output, expected):
    assert reasons.reason(output) == expected


def test_a_roslaunch_whose_program_has_died_is_told_from_one_that_has_finished():
    assert reasons.died(ENDED.format(node='camera'))
    assert not reasons.died('[turtlesim-1] process has finished cleanly\n' + STARTED)
