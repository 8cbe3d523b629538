#!/usr/bin/env python3
"""Nodes whose output is closed, whose reader has gone, or whose log cannot be written: all but lessons continue.

The environment's ROUNDS sets how often; conditions take turns, so that after four rounds each node has met each.
"""
import os
import tempfile
import time
import unittest

from nodes_tools import Nodes, OwnMaster, all_kinds
from rostest_support.common import run
from rostest_support.node_kinds import HARDENED

ROUNDS = int(os.environ.get('ROUNDS', '1'))
SPAN = 3.0  # [s] in which every node logs, most of them often
CLOSED = 'bash', '-c', 'exec "$0" "$@" >&- 2>&-'
UNREAD = 'bash', '-c', 'exec "$0" "$@" > >(exec true) 2>&1'
NO_FOLDER = 'env', 'ROS_LOG_DIR=/dev/null/log', 'TMPDIR=/dev/null/tmp'
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
            simulators = [kind for kind in kinds if not kind.needs]
            nodes.start(*simulators, under=under)
            nodes.spawn_turtles()
            nodes.start(*(kind for kind in kinds if kind.needs), under=under)
            time.sleep(SPAN)
            for kind in kinds:
                self.assert_goes_on(nodes, kind, under[kind])
            nodes.stop()

    def assert_goes_on(self, nodes, kind, condition):
        """The node runs, and has reported the problem with its log once."""
        process, output = nodes.running[kind], nodes.output(kind)
        self.assertTrue(process.runs(), f'{kind.key} under {condition} ended with {process.process.poll()}:\n{output}')
        self.assertEqual(set(), {word for word in BROKEN if word in output}, output)
        if condition[0] == 'env':
            self.assertEqual(1, output.count(NO_LOG), f'{kind.key} under {condition}:\n{output}')


if __name__ == '__main__':
    run(OutputTest)
