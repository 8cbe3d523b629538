#!/usr/bin/env python3
"""Nodes whose output is closed, whose reader has gone, or whose log cannot be written: all but lessons go on as ever.

The environment's ROUNDS sets how often; conditions take turns, so that after four rounds each node has met each.
"""
import os
import subprocess
import tempfile
import time
import unittest

from nodes_tools import Nodes, OwnMaster, all_kinds, command_of

from rostest_support import node_kinds
from rostest_support.common import run
from rostest_support.node_kinds import HARDENED

ROUNDS = int(os.environ.get('ROUNDS', '1'))
SPAN = 3.0  # [s] in which every node logs, most of them often
CLOSED = 'bash', '-c', 'exec "$0" "$@" >&- 2>&-'
UNREAD = 'bash', '-c', 'exec "$0" "$@" > >(exec true) 2>&1'
NO_FOLDER = 'env', 'ROS_LOG_DIR=/dev/null/log', 'TMPDIR=/dev/null/tmp'
PRINTER = node_kinds.BY_KEY['pose_subscriber']  # does nothing but print, and ends with its reader
NO_LOG = 'no log file'
BROKEN = 'Traceback', 'Logging error', 'BrokenPipe', 'Exception ignored'


class OutputTest(unittest.TestCase):

    def setUp(self):
        self.master = OwnMaster()
        self.master.start()
        self.addCleanup(lambda: self.master.process.stop())
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for kind in all_kinds(HARDENED):
            os.symlink('/dev/full', os.path.join(folder.name, f'{kind.node[1:]}.log'))
        full = 'env', f'ROS_LOG_DIR={folder.name}'
        self.conditions = CLOSED, full, UNREAD, NO_FOLDER

    def test_nodes_output(self):
        """Every kind of node but lessons, under one of the conditions is registered, and lives on while it logs."""
        for number in range(ROUNDS):
            nodes, kinds = Nodes(self.addCleanup, self.master), all_kinds(HARDENED)
            under = {kind: self.conditions[(index + number) % len(self.conditions)] for index, kind in enumerate(kinds)}
            under.update({kind: CLOSED for kind in kinds if kind.key == PRINTER.key and under[kind] == UNREAD})
            simulators = [kind for kind in kinds if not kind.needs]
            nodes.start(*simulators, under=under)
            nodes.spawn_turtles()
            nodes.start(*(kind for kind in kinds if kind.needs), under=under)
            self.assert_a_printer_ends_with_its_reader()
            time.sleep(SPAN)
            for kind in kinds:
                self.assert_goes_on(nodes, kind, under[kind])
            nodes.stop()

    def assert_goes_on(self, nodes, kind, condition):
        """The node runs, and what is wrong with its log it said once."""
        process, said = nodes.running[kind], nodes.output(kind)
        self.assertTrue(process.runs(), f'{kind.key} under {condition} ended with {process.process.poll()}:\n{said}')
        self.assertEqual(set(), {word for word in BROKEN if word in said}, said)
        if condition[0] == 'env':
            self.assertEqual(1, said.count(NO_LOG), f'{kind.key} under {condition}:\n{said}')

    def assert_a_printer_ends_with_its_reader(self):
        """``pose_subscriber.py | head -3`` prints three lines and ends, quietly."""
        command = ['bash', '-c', '{ "$0" "$@"; echo "code $?" >&2; } | head -3',
                   *command_of(PRINTER, ''), '__name:=printer', '_rate:=0']
        done = subprocess.run(command, capture_output=True, text=True, timeout=60.0,
                              env=dict(os.environ, ROS_MASTER_URI=self.master.uri))
        self.assertEqual((3, 'code 0\n'), (done.stdout.count('\n'), done.stderr), done)


if __name__ == '__main__':
    run(OutputTest)
