#!/usr/bin/env python3
"""Every lesson ends at Ctrl-C: in time, with the exit code 0, and without a traceback."""
import signal
import time

import rospy

from rostest_support.common import DEADLINE, Process, registered_names, run, until
from rostest_support.course import CourseCase
from rostest_support.node_pages import REPOSITORY

LESSONS = ('packages/tutorials/rospy_tutorials/[0-9]*/[!.]*', 'packages/tutorials/actionlib_tutorials/scripts/*',
           'packages/tutorials/turtle_*/scripts/*')  # programs that are nodes
AT_ONCE = 8
SETTLED = 0.5  # [s] in which a node registers nothing more


class LessonsEndTest(CourseCase):

    def await_all_registered(self, started):
        """Wait until each node has registered something but its log, and none registers anything more.

        ``started``: pairs of a name and a Process; a client may have its result and have ended.
        """
        seen, changed = [], time.monotonic()

        def settled():
            nonlocal seen, changed
            now = [set().union(*registered_names(f'/{name}')) - {'/rosout'} or not process.runs()
                   for name, process in started]
            if now != seen:
                seen, changed = now, time.monotonic()
            return all(seen) and time.monotonic() - changed > SETTLED
        until(settled, lambda: f'all registered: {seen}', 2.0 * DEADLINE)

    def test_lessons_end(self):
        """Each is interrupted once it has registered all that it has."""
        settings = {'global_example': 1, 'utterance': 'hello', 'gains': {'P': 1, 'I': 2, 'D': 3}}  # of param_talker.py
        for name, value in settings.items():
            rospy.set_param(f'/{name}', value)
            self.addCleanup(rospy.delete_param, f'/{name}')
        lessons = [path for pattern in LESSONS for path in sorted(REPOSITORY.glob(pattern))
                   if 'init_node' in path.read_text(encoding='utf-8')]
        self.assertGreater(len(lessons), 40)
        for first in range(0, len(lessons), AT_ONCE):
            started = []
            for number, path in enumerate(lessons[first:first + AT_ONCE], first):
                process = Process(str(path), f'__name:=lesson{number}', '_turtle:=turtle1', '_topic_name:=chatter')
                self.addCleanup(process.stop)
                started.append((f'lesson{number}', process))
            self.await_all_registered(started)
            for _, process in started:
                process.process.send_signal(signal.SIGINT)
            for _, process in started:
                self.assertNotIn('Traceback', self.ended(process))


if __name__ == '__main__':
    run(LessonsEndTest)
