"""``./run doctor``: print each problem of this machine, or of a package, with its remedy. It changes nothing.

Exit codes: 0 nothing will fail, 1 something will, 2 usage error.
"""
import argparse
import json
import os
import subprocess
import sys
from typing import List, Optional, Sequence

from plain_support.doctor import findings, package_checks, ros_checks, system_checks, terminal_checks
from plain_support.doctor.findings import Finding
from plain_support.doctor.machine import Machine

CHECKS = [*terminal_checks.CHECKS, *system_checks.CHECKS, *ros_checks.CHECKS]
WILL_FAIL, NOTE = 'FAILS', 'note'


def examine(machine: Machine) -> List[Finding]:
    """Return all findings, those that will fail first."""
    found: List[Finding] = []
    for check in CHECKS:
        try:
            found += check(machine)
        except subprocess.TimeoutExpired as error:
            found.append(findings.no_answer(error.cmd, error.timeout, fails=False))
    return sorted(found, key=lambda finding: not finding.fails)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Print the findings; return the exit code."""
    options = _parse(arguments)
    machine = Machine(dict(os.environ), options.repository, options.workspace, options.ros, options.missing.split())
    lines: List[str] = []
    if options.package:
        folder = package_checks.folder_of(options.package, machine)
        if not folder:
            print(f'./run doctor: {options.package!r} is neither a folder nor a package that this terminal knows. '
                  'Type the path of its folder.', file=sys.stderr)
            return 2
        try:
            found, lines = package_checks.examine(folder, machine)
        except subprocess.TimeoutExpired as error:
            found = [findings.no_answer(error.cmd, error.timeout, fails=True)]
    else:
        found = examine(machine)
    if options.json:
        print(json.dumps([finding._asdict() for finding in found], indent=2))
    else:
        for finding in found:
            print(f'{WILL_FAIL if finding.fails else NOTE:5s} {finding}')
        print(*lines, summary(found, bool(options.package)), sep='\n')
    return 1 if any(finding.fails for finding in found) else 0


def summary(found: Sequence[Finding], of_a_package: bool = False) -> str:
    """Return the last line of the output."""
    if not found and of_a_package:
        return 'Nothing is missing.'
    if not found:
        return f'Nothing is wrong: {len(CHECKS)} checks of terminal, programs, system, network, master and devices.'
    errors = sum(finding.fails for finding in found)
    notes = len(found) - errors
    if not errors:
        return f'{_count(notes, "note")}, no errors.'
    return ', '.join(_count(number, noun) for number, noun in ((errors, 'error'), (notes, 'note')) if number) + '.'


def _count(number: int, noun: str) -> str:
    return f'{number} {noun}' if number == 1 else f'{number} {noun}s'


def _parse(arguments: Optional[Sequence[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='./run doctor', epilog='Exit code: 0 nothing will fail, 1 something will.',
                                     description='Says what is wrong on this machine and what to do about it. It looks '
                                     'at the system, the terminal that it is called in, the ROS master and devices, '
                                     'and changes nothing. With a package, it says what that one lacks here.')
    parser.add_argument('package', nargs='?', default='', metavar='PACKAGE|FOLDER',
                        help='a package that somebody else wrote, or a folder with packages: what they need and what '
                        'is missing, by package.xml, CMakeLists.txt, launch files, C++ and Python')
    parser.add_argument('--json', action='store_true', help='print a list of {name, text, cure, fails}')
    for name in ('repository', 'workspace', 'ros', 'missing'):  # filled in by ./run
        parser.add_argument(f'--{name}', default='', help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


if __name__ == '__main__':
    sys.exit(main())
