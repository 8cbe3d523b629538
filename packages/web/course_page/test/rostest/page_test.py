#!/usr/bin/env python3
"""The page in a real browser: it shows the simulators, drives them, and stops them when it is left."""
import base64
import contextlib
import json
import os
import pathlib
import re
import shutil
import socket
import tempfile
import unittest
import urllib.parse

import numpy as np
import rosgraph
import roslib.packages
import rospy
from geometry_msgs.msg import Twist
from robotont_gazebo.srv import MoveMarker, SetPose
from sensor_msgs.msg import Image
from sim_ros.msg import ClockStatus
from sim_ros.srv import SetRate
from std_msgs.msg import String

from rospy_support import own_master
from rospy_support.ports import free_port
from rostest_support import browser
from rostest_support.browser import Browser
from rostest_support.common import (
    Collected,
    Process,
    SimulatorCase,
    nightly,
    own_simulator,
    proxy,
    run,
    skip,
    until,
)
from rostest_support.forwarder import Forwarder
from rostest_support.node_pages import REPOSITORY

SERVER = roslib.packages.find_node('course_page', 'browser')[0]
BROWSER_PAGE = REPOSITORY / 'docs/browser.md'
FAVICON = 'location = /favicon.ico { return 204; }'  # Chromium asks for it beside a picture, sooner or later
NGINX = """daemon off; pid {0}/pid; events {{}}
http {{
  access_log off; client_body_temp_path {0}/a; proxy_temp_path {0}/b; fastcgi_temp_path {0}/c; uwsgi_temp_path {0}/d;
  scgi_temp_path {0}/e;
  {1}
}}"""
SIZE = 500  # [px] of the canvas
STALL = 3.0  # [s] that the page is busy; its server has to stop the turtle long before
LOOKS = pathlib.Path(__file__).resolve().parents[1] / 'looks.js'
SCREENS = (1440, 900, False), (390, 844, True), (844, 390, True), (720, 450, False)  # the last: 200 % zoom


def listens(port):
    """Return whether a server of this machine listens at a port."""
    with contextlib.suppress(OSError), socket.create_connection(('127.0.0.1', port), 1.0):
        return True
    return False


class WholeAnswers(Forwarder):
    """A proxy that leads from a path to a port, and passes on answers once they are whole, but for WebSockets."""

    PATH = b'/user/ann/proxy/8000/'

    def _serve(self, client, server):
        with client, server, contextlib.suppress(OSError):
            request = client.recv(65536).replace(self.PATH, b'/', 1)
            if b'Upgrade: websocket' in request:
                server.sendall(request)
                super()._serve(client, server)
                return
            server.sendall(request.replace(b'Connection: keep-alive', b'Connection: close'))
            client.sendall(b''.join(iter(lambda: server.recv(65536), b'')))


class PageCase(unittest.TestCase):
    """A test with a browser, whose page shows a panel."""

    environment = {}  # of the page's server

    @classmethod
    def setUpClass(cls):
        """Start server and browser."""
        server = Process(SERVER, '--port=0', **cls.environment)
        cls.addClassCleanup(server.stop)
        cls.address = server.wait_for_output(r'http://\S+').group()
        cls.page = Browser()
        cls.addClassCleanup(cls.page.close)

    def looks(self, name, *arguments):
        """Return what a function of looks.js returns."""
        return self.page.call(LOOKS, f'looks.{name}', *arguments)

    def text(self, selector):
        """Return the text of the first element; '' if there is none."""
        return next((element.text for element in self.page.find(selector)), '')

    def show(self, panel, width=1280, height=800, touch=False):
        """Show a panel in a page that is loaded anew."""
        self.page.resize(width, height, touch)
        self.page.get('about:blank')
        self.page.get(f'{self.address}#/{panel}')
        self.page.until(lambda: self.page.find('#link.good'), 'a connection')

    def key(self, kind, code):
        """Press ('keyDown') or release ('keyUp') a key."""
        self.page.devtools('Input.dispatchKeyEvent', type=kind, code=code, key=code)

    def press(self, text):
        """Click the button with a text, as a program does: it may be outside of the window."""
        self.page.evaluate(f'[...document.querySelectorAll("button")].find(one => one.textContent === {text!r})'
                           '.click()')

    def middle(self, selector):
        """Return where the middle of an element is, in the window."""
        return self.looks('middle', selector)

    def pixels(self):
        """Return the canvas of the page, (SIZE, SIZE, 3) uint8."""
        data = np.frombuffer(base64.b64decode(self.looks('pixels')), np.uint8)
        return data.reshape(SIZE, SIZE, 4)[:, :, :3]


class PageTest(PageCase, SimulatorCase):
    def tearDown(self):
        """Let no error of the page pass."""
        self.assertEqual([], self.page.errors())

    def show_turtle(self, **options):
        """Show the panel of turtlesim once it has the pose of turtle1."""
        self.show('turtle', **options)
        self.page.until(lambda: re.match(r'\d', self.text('.pose dd')), 'a pose')

    def publish_camera(self):
        """Publish an image of the Robotont's camera, latched until the end of the test."""
        image = rospy.Publisher('/camera/color/image_raw', Image, latch=True, queue_size=1)
        self.addCleanup(image.unregister)
        image.publish(Image(width=64, height=36, step=192, encoding='rgb8', data=bytes(64 * 36 * 3)))

    def velocities(self):
        """Return the Collected velocities for turtle1."""
        collected = Collected('/turtle1/cmd_vel', Twist)
        self.addCleanup(collected.subscriber.unregister)
        return collected

    def assert_snapshot(self, what):
        """Assert that the page's canvas becomes that of a snapshot; there must be no turtle in it."""
        import cv2
        picture = cv2.imdecode(np.frombuffer(self.snapshot(), np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1]
        until(lambda: np.array_equal(self.pixels(), picture),
              lambda: f'{what}: {(self.pixels() != picture).any(axis=2).sum()} pixels differ')

    def test_canvas_has_the_pixels_of_the_snapshot(self):
        """The drawing from before the page was opened, and changes afterwards, with all widths of pens."""
        def draw(first):
            for step in range(first, first + 12):
                self.call('turtle1/set_pen', 20 * step % 256, 255 - 9 * step, 40, 1 + step % 7, 0)
                self.call('turtle1/teleport_absolute', 1 + 7 * step % 10, 1 + 3 * step % 10, 0.0)
        draw(0)
        self.show_turtle()
        draw(12)
        self.driver()(x=3.0, turn=2.0)
        self.poses().next(lambda pose: pose.linear_velocity == 0.0, 'the turtle standing again')
        self.call('kill', 'turtle1')
        self.assert_snapshot('strokes')
        self.set_parameter('background_g', 200)
        self.call('clear')
        self.assert_snapshot('another background')
        rospy.delete_param('/turtlesim/background_g')
        self.call('clear')

    def test_keys_drive_until_they_are_let_go(self):
        self.show_turtle()
        commands, poses = self.velocities(), self.poses()
        self.key('keyDown', 'ArrowUp')
        self.key('keyDown', 'ArrowLeft')
        commands.next(lambda twist: twist.linear.x == 2.0 and twist.angular.z == 2.0, 'both keys')
        poses.next(lambda pose: pose.theta > 0.3, 'the turtle turning')
        self.key('keyUp', 'ArrowLeft')
        commands.next(lambda twist: twist.linear.x == 2.0 and twist.angular.z == 0.0, 'one key')
        self.key('keyUp', 'ArrowUp')
        poses.next(lambda pose: pose.linear_velocity == 0.0, 'the turtle standing')
        self.assertEqual(Twist(), commands.messages[-1])
        self.page.evaluate('document.querySelector("input[type=number]").focus()')
        count = len(commands.messages)
        self.key('keyDown', 'ArrowUp')
        self.key('keyUp', 'ArrowUp')
        self.assertEqual(count, len(commands.messages), 'a key in a field drives')

    def test_page_that_stalls_or_leaves_stops_the_turtle(self):
        """A window without focus, a page that is busy, and one that is closed; the turtle would drive for 1 s more."""
        ends = {'blur': 'void window.dispatchEvent(new Event("blur"))',
                'busy': f'void setTimeout(() => {{ const end = Date.now() + {1000 * STALL}; '
                        'while (Date.now() < end); })',
                'closed': 'void (location.href = "about:blank")'}
        for name, script in ends.items():
            with self.subTest(name):
                self.show_turtle()
                commands = self.velocities()
                self.key('keyDown', 'ArrowUp')
                commands.next(lambda twist: twist.linear.x == 2.0, 'driving')
                start = len(commands.messages)
                self.page.evaluate(script)
                commands.index(lambda twist: twist == Twist(), 'a zero velocity', start)
                self.key('keyUp', 'ArrowUp')

    def test_simulator_does_what_its_buttons_say(self):
        self.show_turtle()
        poses = self.poses()
        self.press('Pause')
        self.page.until(lambda: 'Paused' in self.text('.arena .badge'), 'a sign of the pause')
        self.press('Resume')
        self.page.until(lambda: not self.page.find('.arena .badge')[0].is_displayed(), 'no sign')
        self.looks('setRate', 0.5)
        poses.next(lambda pose: pose.linear_velocity == 0.0)
        Collected('/turtlesim/clock_status', ClockStatus).index(lambda status: status.rate == 0.5, 'half the rate', 0)
        self.page.until(lambda: '0.5 times real time' in self.text('#panel'), 'the rate')
        self.page.until(lambda: 'other nodes use wall time' in self.text('#panel'), 'what to know about it')
        proxy('/turtlesim/set_rate', SetRate)(1.0)
        self.press('Spawn')  # the tool above the canvas, which comes first
        x, y = self.middle('.arena')
        for kind in ('mousePressed', 'mouseReleased'):
            self.page.devtools('Input.dispatchMouseEvent', type=kind, x=x, y=y - 100, button='left', clickCount=1)
        until(lambda: 'turtle2' in self.turtles(), 'a second turtle')
        self.assertLess(abs(self.pose('turtle2').x - 5.5), 0.1)
        self.assertGreater(self.pose('turtle2').y, 6.5)
        self.page.until(lambda: 'spawn' in self.text('.command-now code'), 'the command')
        self.press('Reset')
        poses.next(lambda pose: True)
        until(lambda: self.turtles() == {'turtle1'}, 'one turtle again')

    def test_a_simulator_that_falls_behind_is_said(self):
        self.show_turtle()
        status = rospy.Publisher('/turtlesim/clock_status', ClockStatus, queue_size=1)
        self.addCleanup(status.unregister)

        def shows_it():
            status.publish(rate=1.0, pace=0.6)
            return 'Slow: 0.6 times real time' in self.text('.arena .badge') and 'not 1: this' in self.text('#panel')
        self.page.until(shows_it, 'a sign that time passes too slowly')

    @nightly
    def test_the_recipe_for_a_proxy_works_below_a_path(self):
        """docs/browser.md's part of an nginx configuration, with a path such as JupyterHub's."""
        nginx = shutil.which('nginx', path=f'{os.environ["PATH"]}:/usr/sbin')
        if not nginx:
            self.skipTest('nginx is not installed')
        recipe, = re.findall(r'```\n(map .*?)```', BROWSER_PAGE.read_text('utf-8'), re.DOTALL)
        port, path = free_port(), '/user/ann/proxy/8000/'
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        for old, new in (('/turtle/', path), ('/etc/nginx/turtle_passwords', f'{folder}/passwords'),
                         ('http://127.0.0.1:8000/', self.address),
                         ('server {', f'server {{ listen 127.0.0.1:{port}; {FAVICON}')):
            self.assertEqual(1, recipe.count(old), old)
            recipe = recipe.replace(old, new)
        for name, text in (('passwords', 'ann:{PLAIN}secret\n'), ('nginx.conf', NGINX.format(folder, recipe))):
            pathlib.Path(folder, name).write_text(text, 'utf-8')
        os.chmod(folder, 0o755)
        proxy = Process(nginx, '-p', folder, '-c', f'{folder}/nginx.conf', '-e', 'stderr')
        self.addCleanup(proxy.stop)
        until(lambda: listens(port), lambda: f'nginx: {proxy.output()}')
        self.page.get(f'http://ann:secret@localhost:{port}{path}icon.svg')  # Chromium remembers the password
        self.addCleanup(self.page.get, 'about:blank')  # before nginx ends the stream of pictures
        self.address = f'http://localhost:{port}{path}'
        self.show_turtle()
        self.page.until(lambda: self.page.find('#link.good'), 'a WebSocket through the proxy')
        commands = self.velocities()
        self.key('keyDown', 'ArrowUp')
        commands.next(lambda twist: twist.linear.x == 2.0, 'driving')
        self.key('keyUp', 'ArrowUp')
        self.show('grade')
        self.page.until(lambda: 'publish_circle' in self.page.evaluate('document.body.textContent'), 'exercises')
        self.show('image?topic=/turtlesim/image_raw')
        self.page.until(lambda: '500 x 500 pixels' in self.text('#panel'), 'a picture')

    @nightly
    def test_pictures_pass_a_proxy_that_waits_for_the_end_of_an_answer(self):
        """As that of JupyterLab and JupyterHub, jupyter-server-proxy, does; a stream has no end."""
        proxy = WholeAnswers(('127.0.0.1', urllib.parse.urlsplit(self.address).port))
        self.addCleanup(proxy.close)
        self.addCleanup(self.page.get, 'about:blank')
        self.address = f'http://localhost:{proxy.port}{proxy.PATH.decode()}'
        self.show('image?topic=/turtlesim/image_raw')
        self.page.until(lambda: '500 x 500 pixels' in self.text('#panel'), 'a picture')
        self.driver()(x=2.0, turn=1.0)
        self.page.until(lambda: 'It has not changed' not in self.text('#panel'), 'the next pictures')
        self.publish_camera()
        self.show('robot')
        self.page.until(lambda: self.page.evaluate('document.querySelector(".camera img")?.naturalWidth'), 'the camera')

    @nightly
    def test_marker_is_dragged(self):
        """Where it is let go is its new place; the map shows it there, and stays where it was."""
        before = self.marker()
        self.show('robot')
        self.looks('catchMap')
        x, y, scale = self.page.until(lambda: self.looks('marker', 'marker3'), 'the markers')
        for kind, way in (('mousePressed', 0), ('mouseMoved', 30), ('mouseMoved', 60), ('mouseReleased', 60)):
            self.page.devtools('Input.dispatchMouseEvent', type=kind, x=x + way, y=y, button='left', buttons=1,
                               clickCount=1)
        until(lambda: self.marker() != before, 'the marker in another place')
        after = self.marker()
        self.assertAlmostEqual(before['x'] + 60 / scale, after['x'], delta=2 / scale + 0.01)
        self.assertAlmostEqual(before['y'], after['y'], delta=0.015)  # both are shown to the cm
        self.assertAlmostEqual(before['yaw'], after['yaw'], delta=1e-3)
        self.page.until(lambda: 'move_marker' in self.text('.command-now code'), 'the command')
        proxy('/robotont_gazebo/move_marker', MoveMarker)('marker3', before['x'], before['y'], before['yaw'])

    def marker(self):
        """Return marker 3 of the simulated world."""
        world = json.loads(Collected('/robotont_gazebo/world', String).some(0, 1)[0].data)
        return next(one for one in world['panels'] if one['name'] == 'marker3')

    def test_robot_is_driven_by_two_fingers(self):
        proxy('/robotont_gazebo/set_pose', SetPose)(-2.0, 0.0, 0.0)
        self.show('robot', 390, 844, touch=True)
        self.page.until(lambda: self.page.find('.map'), 'the map')
        commands = Collected('/cmd_vel', Twist)
        self.addCleanup(commands.subscriber.unregister)
        move, turn = self.middle('.joystick'), self.middle('.joystick + .joystick')
        self.page.touch(move, turn)
        for way in (15, 30, 60):
            self.page.devtools('Input.dispatchTouchEvent', type='touchMove', touchPoints=[
                {'x': move[0] - way, 'y': move[1] - way, 'id': 0}, {'x': turn[0] - way, 'y': turn[1], 'id': 1}])
        commands.next(lambda twist: twist.linear.x > 0.2 and twist.linear.y > 0.2 and twist.angular.z > 1.0,
                      'forward, sideways and turning at once')
        start = len(commands.messages)
        self.page.touch()
        commands.index(lambda twist: twist == Twist(), 'a zero velocity', start)
        self.page.until(lambda: re.match(r'-?\d', self.text('.pose dd')), 'a pose')

    @nightly
    def test_picture_and_controls_are_on_one_screen(self):
        self.publish_camera()
        panels = {'turtle': ['.arena', '[aria-label=Forward]', '.stop'],
                  'robot': ['.map', '.camera img', '.joystick', '.joystick + .joystick']}
        for panel, elements in panels.items():
            self.show(panel)
            for width, height, touch in SCREENS:
                self.page.resize(width, height, touch)
                self.until_seen(f'{panel} at {width}x{height}', [*elements, '#menu [aria-current]'])
                self.page.screenshot(f'{panel}_{width}x{height}')

    def until_seen(self, where, selectors):
        """Wait until all of these are in the window."""
        self.page.evaluate('document.querySelector("main").scrollTo(0, 0)')
        self.page.until(lambda: all(self.page.find(selector) for selector in selectors), f'{where}: {selectors}')
        self.page.until(lambda: not self.looks('hidden', selectors), f'{where}: these are to be seen: {selectors}')

    @nightly
    def test_a_network_that_stands_still_is_said(self):
        proxy = Forwarder(('127.0.0.1', urllib.parse.urlsplit(self.address).port))
        self.addCleanup(proxy.close)
        self.show_turtle()
        self.page.get('about:blank')
        self.page.get(f'http://localhost:{proxy.port}/#/turtle')
        self.page.until(lambda: self.page.find('#link.good') and re.match(r'\d', self.text('.pose dd')), 'a pose')
        commands, poses = self.velocities(), self.poses()
        self.key('keyDown', 'ArrowUp')
        commands.next(lambda twist: twist.linear.x == 2.0, 'driving')
        proxy.stalled.set()
        poses.next(lambda pose: pose.linear_velocity == 0.0, 'the turtle standing, which the server stops')
        self.page.until(lambda: 'Nothing has come from the server for 2 s' in self.text('#banner'), 'the stall')
        self.assertEqual('No answer', self.text('#link'))
        self.assertEqual('0.55', self.page.evaluate('getComputedStyle(document.querySelector(".body")).opacity'))
        proxy.stalled.clear()
        self.page.until(lambda: self.page.find('#link.good'), 'a connection')
        self.key('keyUp', 'ArrowUp')
        self.page.errors()  # requests that took too long

    @nightly
    def test_who_else_drives_is_said(self):
        self.show_turtle()
        self.driver()(x=1.0)
        self.page.until(lambda: f'{rospy.get_name()} publishes on /turtle1/cmd_vel, too.' in self.text('.others'),
                        'this node')
        with Browser() as other:
            other.get(f'{self.address}#/turtle')
            other.until(lambda: other.find('#link.good') and re.match(r'\d', other.find('.pose dd')[0].text), 'a pose')
            other.devtools('Input.dispatchKeyEvent', type='keyDown', code='ArrowLeft', key='ArrowLeft')
            self.page.until(lambda: 'Another page drives now.' in self.text('.others'), 'the other page')
            other.devtools('Input.dispatchKeyEvent', type='keyUp', code='ArrowLeft', key='ArrowLeft')
            self.page.until(lambda: 'Another page' not in self.text('.others'), 'its end')


class MasterTest(PageCase):
    port = free_port()
    environment = {'ROS_MASTER_URI': f'http://localhost:{port}'}

    @nightly
    def test_page_says_what_is_missing_and_connects_again(self):
        """Without a master, without a simulator, and with those that come later, twice."""
        self.page.get(self.address)
        for _ in range(2):
            self.page.until(lambda: 'No roscore is running' in self.text('#banner'), 'what is missing')
            self.assertIn('roscore', [one.text for one in self.page.find('#banner code')])
            master = own_master.start_master(lambda command: Process(*command), self.port).process
            self.addCleanup(master.stop)
            self.page.until(lambda: self.page.find('#link.good'), 'a connection')
            known = rosgraph.Master('/test', self.environment['ROS_MASTER_URI'])
            self.until_port_is_known(known)
            self.page.until(lambda: 'No turtlesim is running' in self.text('#panel'), 'what to start')
            simulator = own_simulator(**self.environment)
            self.addCleanup(simulator.stop)
            self.page.until(lambda: re.match(r'5\.54', self.text('.pose dd')), 'the turtle')
            self.key('keyDown', 'ArrowUp')
            self.page.until(lambda: float(self.text('.pose dd')) > 6.0, 'the turtle driving')
            self.key('keyUp', 'ArrowUp')
            simulator.stop()
            master.stop()

    def until_port_is_known(self, master):
        """Wait until a master, perhaps a new one, knows where the page is."""
        until(lambda: master.hasParam('/browser/actual_port'), 'the port, on each master')
        self.assertEqual(urllib.parse.urlsplit(self.address).port, master.getParam('/browser/actual_port'))


if __name__ == '__main__':
    if browser.MISSING:
        skip(browser.MISSING)
    else:
        run(PageTest, MasterTest)
