#!/usr/bin/env python3
"""The page of a container, opened on its host: what compose.yaml starts, in a network of its own.

Two network namespaces with a cable between them stand for the container and its host. A program on the host forwards
the published port, as a container engine does, so that the page sees an address that is not its own machine's.
"""
import contextlib
import ctypes
import os
import re
import shlex
import unittest
import urllib.error
import urllib.request

import yaml

import two_machines_test
from rostest_support import browser
from rostest_support.browser import Browser
from rostest_support.common import Process, run, skip, until
from rostest_support.forwarder import Forwarder
from rostest_support.node_pages import REPOSITORY
from two_machines_test import LAPTOP, ROBOT, Machine

STARTED = r'Open (http://localhost:(\d+)/\?token=\S+) in a browser'
START_DEADLINE = 60.0  # [s] until the page has an address; on an idle machine it takes 5


@contextlib.contextmanager
def network_of(machine):
    """Let this thread, and the programs that it starts, use the network of a machine."""
    library = ctypes.CDLL(None, use_errno=True)
    with open('/proc/thread-self/ns/net', 'rb') as own, open(f'/proc/{machine.pid}/ns/net', 'rb') as other:
        if library.setns(other.fileno(), 0):
            raise OSError(ctypes.get_errno(), 'setns')
        try:
            yield
        finally:
            library.setns(own.fileno(), 0)


class PublishedPageTest(unittest.TestCase):

    def setUp(self):
        self.container, self.host = Machine(ROBOT), Machine(LAPTOP)
        self.addCleanup(self.host.remove)
        self.addCleanup(self.container.remove)
        two_machines_test.connect(self.container, self.host)

    def test_the_address_that_the_container_prints_works_on_its_host(self):
        with open(os.path.join(REPOSITORY, 'compose.yaml'), encoding='utf-8') as file:
            course = yaml.safe_load(file)['services']['course']
        with open(os.path.join(REPOSITORY, 'Dockerfile'), encoding='utf-8') as file:
            listen = re.search(r'^ENV TURTLE_ROBOTONT_ADDRESS=(\S+)$', file.read(), re.MULTILINE).group(1)
        program, *arguments = shlex.split(course['command'])
        page = Process(*self.container.command(
            'env', '-u', 'ROS_MASTER_URI', '-u', 'ROS_HOSTNAME', f'TURTLE_ROBOTONT_ADDRESS={listen}',
            os.path.join(REPOSITORY, program), *arguments))
        self.addCleanup(page.stop)
        address, port = page.wait_for_output(STARTED, START_DEADLINE).groups()
        here, outside, inside = course['ports'][0].split(':')
        self.assertEqual((port, port), (outside, inside))
        self.assertEqual('127.0.0.1', here)
        with network_of(self.host):
            forwarder = Forwarder((ROBOT, int(port)), int(port))
            self.addCleanup(forwarder.close)
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(address.partition('?')[0], timeout=20)
            self.assertIn('the token is missing', refused.exception.read().decode())
            self.drive(address)

    def drive(self, address):
        """Open the page, and drive the turtle by an arrow key."""
        with Browser() as page:
            page.get(address)

            def x():
                return float(next(value.text for value in page.find('.pose dd') if re.match(r'\d', value.text)))
            page.until(lambda: page.find('#link.good') and page.find('.pose dd')[0].text[0] in '0123456789', 'a turtle')
            page.devtools('Input.dispatchKeyEvent', type='keyDown', code='ArrowUp', key='ArrowUp')
            until(lambda: x() > 6.0, 'the turtle driving')
            page.devtools('Input.dispatchKeyEvent', type='keyUp', code='ArrowUp', key='ArrowUp')
            self.assertNotIn('token', page.driver.current_url)
            page.driver.refresh()  # a cookie has the token
            page.until(lambda: page.find('#link.good'), 'a connection')
            self.assertEqual([], page.errors())


if __name__ == '__main__':
    if browser.MISSING:
        skip(browser.MISSING)
    else:
        two_machines_test.main(lambda: run(PublishedPageTest))
