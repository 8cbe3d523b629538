"""Play the whole course, and measure how the turtle and the robot move."""
import argparse
import contextlib
import os
import re
import signal
import sys
import time
from typing import Callable, NamedTuple

import rospy

from course_grader.demo import course, course_markers, course_navigation, course_next, course_sensors
from course_grader.demo.harness import DemoError, DemoHarness
from plain_support import course as course_steps
from plain_support.processes import INTERRUPTED

TURTLE_PLAYS = {play.__name__: play for module in (course, course_next) for play in module.PLAYS}
ROBOT_PLAYS = {play.__name__: play for module in (course_markers, course_sensors, course_navigation)
               for play in module.PLAYS}
STEP_LIMIT = 600  # [s] for one step, which takes 5 to 20; at a load of 60 on 2 cores, 10 took 340 together
STEP_ERRORS = (DemoError, rospy.ROSException, rospy.ServiceException)
GREEN, RED, PLAIN = '\033[32m', '\033[31m', '\033[0m'


class Step(NamedTuple):
    """What the demo plays of a step of the course: an entry ``demo`` of its step.yaml, with the function that plays it.

    ``turtle``: it moves a turtle, which is reset before and shown in a picture afterwards; the others save pictures
    with ``DemoHarness.keep``.
    """

    number: str
    title: str
    asked: str
    typed: str
    play: Callable
    turtle: bool


def steps():
    """Return the Steps of the course, in its order."""
    plays = {**TURTLE_PLAYS, **ROBOT_PLAYS}
    return [Step(step.number, one.title, one.asks, one.types, plays[one.plays], one.plays in TURTLE_PLAYS)
            for step in course_steps.steps(course_steps.installed()) for one in step.demo]


class OutOfTimeError(Exception):
    """A step takes longer than STEP_LIMIT."""


class Report:
    """Prints the results for people: in colour on a terminal, without check marks if it cannot show them."""

    def __init__(self, out):
        self._out = out
        self._coloured = out.isatty() and 'NO_COLOR' not in os.environ
        try:
            '✓✗'.encode(out.encoding or 'ascii')
            self._marks = {True: '✓', False: '✗'}
        except UnicodeEncodeError:
            self._marks = {True: 'ok', False: 'FAILED'}

    def line(self, text=''):
        """Print a line."""
        print(text, file=self._out, flush=True)

    def verdict(self, good, text, indent=6):
        """Print a line with a check mark or a cross."""
        colour, plain = (GREEN if good else RED, PLAIN) if self._coloured else ('', '')
        self.line(f'{" " * indent}{colour}{self._marks[good]}{plain} {text}')

    def step(self, step):
        """Print the next step."""
        self.line(f'\n{step.number:>3}. {step.title}: {step.asked}')
        self.line(f'      $ {step.typed}')

    def outcome(self, measurements, pose, pictures):
        """Print the results of a step."""
        for measurement in measurements:
            self.verdict(measurement.good, measurement.text)
        if pose is not None:
            self.line(f'      The turtle is at x {pose.x:.3f} m, y {pose.y:.3f} m, heading {pose.theta:.3f} rad')
        for picture in pictures:
            self.line(f'      Picture: {os.path.relpath(picture)}' if picture else
                      '      No picture: this turtlesim has no ~snapshot service')


def play(step, harness, report):
    """Play one step and report on it; return whether all its measurements are good."""
    report.step(step)
    measurements, pictures = [], []
    name = f'{step.number}_{step.title.lower().replace(" ", "_")}'
    try:
        if step.turtle:
            harness.reset()
        measurements += step.play(harness)
    except STEP_ERRORS as error:
        measurements.append(course.Measurement(str(error), False))
    try:
        pictures = [harness.picture(name)] if step.turtle else harness.kept(name)
    except STEP_ERRORS as error:
        measurements.append(course.Measurement(f'no picture: {error}', False))
    harness.end_nodes()
    track = harness.seen.track if step.turtle else []
    report.outcome(measurements, track[-1] if track else None, pictures)
    return all(measurement.good for measurement in measurements)


def play_all(steps, output, report):
    """Play the steps; return the titles of those that failed or did not finish."""
    todo = [step.title for step in steps]
    failed = []
    harness = DemoHarness(output)
    try:
        with _time_limit(STEP_LIMIT):
            harness.open()
        for step in steps:
            with _time_limit(STEP_LIMIT):  # each has its own: a slow machine that gets on is not a reason to stop
                if not play(step, harness, report):
                    failed.append(step.title)
            todo.remove(step.title)
    except OutOfTimeError:
        report.verdict(False, f'Out of time: this step took more than {STEP_LIMIT} s. A node hangs, or the machine is '
                              'too busy')
    except (DemoError, OSError) as error:
        report.verdict(False, str(error))
    finally:
        harness.close()
    return failed + todo


def is_selected(step, word):
    """Return whether a word of the command line is the number of a step or part of its title."""
    return word == step.number if re.fullmatch(r'\d+[a-z]?', word) else word.lower() in step.title.lower()


def main():
    """Play all steps, or those with a given number or a word in the title; exit with 0 only if all passed."""
    with open(os.devnull, 'w', encoding='utf-8') as nowhere:
        try:
            _main(sys.stdout or nowhere)  # None, if the terminal has closed it
        except OSError as error:
            os.dup2(nowhere.fileno(), sys.__stdout__.fileno())  # Python writes what is left there when it ends
            sys.exit(f'./run demo: its output cannot be written: {error.strerror or error}')


def _main(out):
    parser = argparse.ArgumentParser(prog='./run demo', description=__doc__)
    parser.add_argument('--output', default='output', metavar='DIR',
                        help='folder for pictures and logs (default: %(default)s)')
    parser.add_argument('words', nargs='*', metavar='WORD', help='do only the steps with this number in the course, '
                        'or with this word in their title')
    arguments = parser.parse_args(rospy.myargv()[1:])
    known = steps()
    chosen = [step for step in known if not arguments.words or any(is_selected(step, word) for word in arguments.words)]
    if not chosen:
        parser.error('no step has such a number, nor such a word in its title; the steps are: '
                     + ', '.join(f'{step.number} {step.title}' for step in known))
    for number in (signal.SIGINT, signal.SIGTERM):  # in the background, programs would inherit an ignored SIGINT
        signal.signal(number, signal.default_int_handler)
    report, began, output = Report(out), time.monotonic(), os.path.abspath(arguments.output)
    report.line('The course without a display: the nodes of this package do every step, and the demo measures what\n'
                'the turtle or the robot does.')
    try:
        failed = play_all(chosen, output, report)
    except KeyboardInterrupt:
        report.line('\nInterrupted; all processes have ended.')
        sys.exit(INTERRUPTED)
    report.line()
    report.verdict(not failed, f'{len(chosen) - len(failed)} of {len(chosen)} steps passed, in '
                               f'{time.monotonic() - began:.0f} s', indent=0)
    if failed:
        report.line(f'  Failed: {", ".join(failed)}. Output of the nodes: {os.path.relpath(output)}/log')
    else:
        report.line(f'  Pictures: {os.path.relpath(output)}')
    sys.exit(1 if failed else 0)


@contextlib.contextmanager
def _time_limit(seconds):
    def on_alarm(*_):
        raise OutOfTimeError
    signal.signal(signal.SIGALRM, on_alarm)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
