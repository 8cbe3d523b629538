"""The command line options for isolation and limits."""
import argparse
from typing import Tuple

from course_grader.isolation import levels, limits
from course_grader.isolation.confinement import Isolation


def add_options(parser: argparse.ArgumentParser) -> None:
    levels.add_options(parser)
    limits.add_options(parser)


def line(options: argparse.Namespace) -> Tuple[str, ...]:
    """Return the options as typed, for a grader on another machine."""
    asked = {levels.OPTION: options.isolation, levels.REQUIRED: options.require_isolation}
    asked.update((limits.option(name), value) for name, value in limits.chosen(options)._asdict().items())
    return tuple(text for name, value in asked.items() if value for text in (name, str(value)))


def choose(options: argparse.Namespace) -> Tuple[Isolation, str]:
    """Return (Isolation, warning or '') for this machine; raise levels.TooWeak.

    Call it while this process has one thread.
    """
    machine = levels.machine()
    level = levels.decide(machine, options.isolation, options.require_isolation)
    return Isolation(level, limits.chosen(options), users=not machine.uid), levels.warning(level, machine)
