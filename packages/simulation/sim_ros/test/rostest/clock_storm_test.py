#!/usr/bin/env python3
"""Several clients pause, resume and step a simulator at once: it lives, and no step is lost or made twice."""
import csv
import os
import shutil
import tempfile
import threading
import time
import unittest

import rospy
from sim_ros.msg import ClockStatus
from sim_ros.srv import Step
from std_srvs.srv import Trigger

from rostest_support.common import DEADLINE, Collected, own_simulator, proxy, run, until

SECONDS = 4.0  # before the fix, a pause and a resume ended a simulator within 1 s
STEPPED = (0, 1, 2, 25, 100)  # steps of one call


class ClockStormTest(unittest.TestCase):

    def storm(self):
        """Let the clients call; return (steps asked for, answer) of all calls of ~step."""
        answers, end = [], time.monotonic() + SECONDS

        def client(name, kind, arguments):
            call = rospy.ServiceProxy(f'/turtlesim/{name}', kind, persistent=True)
            while time.monotonic() < end:
                for argument in arguments:
                    try:
                        answers.append((argument, call(*argument)))
                    except rospy.ServiceException as refusal:
                        answers.append((argument, refusal))
        clients = [('pause', Trigger, [()]), ('resume', Trigger, [()]), ('step', Step, [(steps,) for steps in STEPPED])]
        threads = [threading.Thread(target=client, args=each, daemon=True) for each in clients * 2]
        for thread in threads:
            thread.start()
        until(lambda: not any(thread.is_alive() for thread in threads), 'an answer to every call', SECONDS + DEADLINE)
        return [(argument[0], answer) for argument, answer in answers if argument]

    def test_turtlesim_clock_storm(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        recording = os.path.join(folder, 'storm.csv')
        process = own_simulator('_clock:=true', f'_record:={recording}')
        self.addCleanup(process.stop)
        rospy.wait_for_service('/turtlesim/step', DEADLINE)
        status, step = Collected('/turtlesim/clock_status', ClockStatus), proxy('/turtlesim/step', Step)
        answers = self.storm()
        refusals = {str(answer) for _, answer in answers if isinstance(answer, rospy.ServiceException)}
        self.assertEqual([], [text for text in refusals if 'the simulator was resumed in the meantime' not in text])
        made = sorted((answer.steps - steps, answer.steps) for steps, answer in answers
                      if steps and not isinstance(answer, rospy.ServiceException))
        self.assertGreater(len(made), 10)
        for (_, end), (begin, _) in zip(made, made[1:]):
            self.assertLessEqual(end, begin, 'a step was given to two clients')
        self.assertTrue(proxy('/turtlesim/pause', Trigger)().success)
        self.assertEqual(step(0).steps + 7, step(7).steps)
        last = step(0)
        until(lambda: (status.messages[-1].steps, status.messages[-1].paused) == (last.steps, True),
              'a status that agrees')
        self.assertEqual(last.time, status.messages[-1].time)
        self.assertNotIn('Traceback', process.output())
        process.stop()
        with open(recording, newline='', encoding='utf-8') as file:
            ticks = [int(row['tick']) for row in csv.DictReader(file)]
        self.assertEqual(list(range(last.steps)), ticks)


if __name__ == '__main__':
    run(ClockStormTest)
