#!/usr/bin/env python3
"""Make the pictures of README.md and of the course that no page of the course saves, from running simulators.

usage: ./run shell -c "cd $PWD && python3 tools/pictures.py [NAME ...]"

A NAME is one of MAKERS below; without one, all are made, in a few minutes. The moving picture shows what was recorded:
turtlesim's canvas, the map and the camera of the robot, what the programs print, and Chromium with the page (Debian:
chromium-driver, python3-selenium). It needs OpenCV 4.11 or newer.
"""
import glob
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import time

import cv2
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_msgs.msg import String

from course_grader.demo.course_markers import START_TIMEOUT, Recorder, map_of, world_plan
from course_grader.demo.harness import DemoHarness
from kinematic_core.worlds import overhead
from rospy_support import images
from rospy_support.ports import free_port
from rostest_support.browser import Browser
from turtle_robotont.driver import pose_of

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
IMAGES, STEPS = REPOSITORY / 'docs' / 'images', REPOSITORY / 'course'
COURSE = 'turtle_robotont'
WIDTH, HEIGHT, HEAD = 760, 430, 44  # [px] of the moving picture; its title line
PAPER, INK, TERMINAL, PRINTED = (250, 252, 252), (52, 44, 40), (46, 38, 34), (225, 228, 214)  # BGR
FONT = cv2.FONT_HERSHEY_SIMPLEX
FRAME = 120  # [ms] that a frame of the moving picture is shown
STILL = 1200  # [ms] of the last one of a scene
QUALITY = 70  # of WebP
SQUARE = [(-2.5, -0.5), (-1.0, 0.9)]  # [m] the part of the maze in which the robot drives its square
FROM_DEMO = {'22_between_posts/between_posts': 'between_posts',
             '24_keep_centre/follow_marker': 'follow_a_marker'}  # {picture: its name in the demo}


def moving_picture(harness):
    """README.md: the turtle, the robot and the page."""
    frames, durations = [], []
    for scene in (_turtle_scene, _robot_scene, _page_scene):
        made = list(scene(harness))
        frames += made
        durations += [FRAME] * (len(made) - 1) + [STILL]
        harness.end_nodes()
    animation = cv2.Animation()
    animation.frames, animation.durations, animation.loop_count = frames, durations, 0
    path = IMAGES / 'course.webp'
    cv2.imwriteanimation(str(path), animation, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(f'{path.name}: {len(frames)} frames, {sum(durations) / 1000:.1f} s, {path.stat().st_size / 1e6:.2f} MB')


def _turtle_scene(harness):
    harness.reset()
    canvas = Recorder('turtlesim/image_raw', Image, images.bgr)
    node = harness.rosrun('velocity_publisher.py', '_linear:=3.0', '_angular:=1.5')
    command = f'rosrun {COURSE} velocity_publisher.py _linear:=3.0 _angular:=1.5'
    harness.until(lambda: len(harness.seen.track) and harness.seen.track[-1].linear_velocity, 'no circle', 30.0, node)
    for _ in range(38):
        time.sleep(FRAME / 1000.0)
        frame = _frame('1  A first program drives the turtle')
        _paste(frame, canvas.entries[-1], 12, HEAD, 374)
        _terminal(frame, 400, HEAD, WIDTH - 412, 374, command, node.output())
        yield frame
    canvas.end()


def _robot_scene(harness):
    with _Maze(harness, 2.0) as maze:
        while not maze.done():
            frame = _frame('2  The robot finds its way by the markers that its camera sees')
            _paste(frame, maze.map(), 12, HEAD, 374)
            _paste(frame, maze.view.entries[-1], 412, HEAD, 189)
            _terminal(frame, 412, HEAD + 197, WIDTH - 424, 177, f'roslaunch {COURSE} ar_maze.launch',
                      maze.node.output())
            yield frame
            time.sleep(0.45)  # 0.9 s of the maze


def _page_scene(harness):
    harness.reset()
    with _Page(harness, 'turtle') as page:
        for keys, count in ((('ArrowUp',), 5), (('ArrowUp', 'ArrowLeft'), 10), (('ArrowUp',), 5), ((), 2),
                            (('ArrowUp', 'ArrowRight'), 10), ((), 3)):
            for key in keys:
                page.key('keyDown', key)
            for _ in range(count):
                frame = _frame('3  ./run view shows and drives both in a browser')
                _paste(frame, page.shot(), 49, HEAD, 374)
                yield frame
                time.sleep(0.05)
            for key in keys:
                page.key('keyUp', key)


def robot_square(harness):
    """Step 10: the square of the robot in the maze."""
    harness.start('roslaunch', 'robotont_gazebo', 'world_minimaze.launch', 'rate:=3')
    world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
    poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
    harness.until(lambda: world.entries and poses.entries, 'no robot', START_TIMEOUT)
    harness.start(str(STEPS / '10_robot_square' / 'robot_square.py')).wait(START_TIMEOUT)
    last = poses.entries[-1]
    path = overhead.Path([(pose.x, pose.y) for pose in poses.entries], label='path of the robot')
    picture = overhead.draw_map(world_plan(world.entries[-1]), [path], [(last.x, last.y, last.theta)],
                                'A square by odometry', pixels_per_metre=270, between=SQUARE)
    for recorder in (world, poses):
        recorder.end()
    harness.end_nodes()
    rospy.set_param('use_sim_time', False)
    _save('10_robot_square/robot_square', cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))


def from_demo(_):
    """The pages of the course: what ./run demo saves."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(['rosrun', 'course_grader', 'demo', '--output', folder, 'marker', 'maze', 'launch', 'follow',
                        'bang', 'controller', 'posts'], check=True)

        def saved(name):
            return cv2.imread(*glob.glob(f'{folder}/[0-9]*_{name}.png'))
        for picture, name in FROM_DEMO.items():
            _save(picture, saved(name))
        _save('21_p_controller/p_controller', np.hstack([saved('bang-bang'), saved('p_controller')]))
        views = saved('ar_markers')
        _save('08_print_marker_ids/ar_markers', _high(views[:views.shape[0] // 2], 300))
        view = saved('ar_maze')[:360, :640]
        seen = np.full((500, 648, 3), 255, np.uint8)
        seen[70:430, 8:] = view
        _save('11_follow_marker/ar_maze', np.hstack([_high(saved('ar_maze_2')[8:-40, 8:-8], 500), seen]))


MAKERS = {'moving_picture': moving_picture, 'robot_square': robot_square, 'from_demo': from_demo}


class _Maze:
    """The robot in the maze, driven by ar_maze.py; a context manager."""

    def __init__(self, harness, rate):
        self._harness = harness
        harness.start('roslaunch', 'robotont_gazebo', 'world_minimaze_ar.launch', f'rate:={rate:g}')
        self._world = Recorder('robotont_gazebo/world', String, lambda message: message.data)
        self._poses = Recorder('robotont_gazebo/ground_truth', Odometry, pose_of)
        harness.until(lambda: self._world.entries and self._poses.entries, 'no robot', START_TIMEOUT)
        self.node = harness.start('roslaunch', COURSE, 'ar_maze.launch', 'sim:=false')
        self.view = Recorder('ar_track_alvar/debug_image', Image, images.bgr)
        harness.until(lambda: self.view.entries, 'no camera', START_TIMEOUT, self.node)

    def done(self):
        """Return whether all markers were visited."""
        return re.search('Visited the markers|FATAL', self.node.output()) is not None

    def map(self):
        """Return the map with the path so far, without its margins."""
        return map_of(world_plan(self._world.entries[-1]), list(self._poses.entries), '')[40:-40, 40:-40]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for recorder in (self._world, self._poses, self.view):
            recorder.end()
        self._harness.end_nodes()
        rospy.set_param('use_sim_time', False)


class _Page:
    """Chromium with a panel of the page; a context manager."""

    def __init__(self, harness, panel):
        port = free_port()
        self._server = harness.start('rosrun', 'course_page', 'browser', f'--port={port}')
        harness.until(lambda: str(port) in self._server.output(), 'no page', START_TIMEOUT, self._server)
        self._folder = tempfile.mkdtemp()
        self._browser = Browser(1120, 640, folder=self._folder)
        self._browser.get(f'http://localhost:{port}/#/{panel}')
        self._browser.until(lambda: self._browser.find('#link.good'), 'a connection')
        self._browser.until(lambda: self._browser.find('canvas'), 'a picture')
        time.sleep(2.0)

    def key(self, kind, code):
        """Press ('keyDown') or release ('keyUp') a key."""
        self._browser.devtools('Input.dispatchKeyEvent', type=kind, code=code, key=code)

    def shot(self):
        """Return a screenshot."""
        return cv2.imread(self._browser.screenshot('page'))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._browser.close()


def _frame(title):
    frame = np.full((HEIGHT, WIDTH, 3), PAPER, np.uint8)
    cv2.putText(frame, title, (14, 30), FONT, 0.7, INK, 1, cv2.LINE_AA)
    return frame


def _high(picture, height):
    """Return the picture with another height [px]."""
    return cv2.resize(picture, (round(picture.shape[1] * height / picture.shape[0]), height),
                      interpolation=cv2.INTER_AREA)


def _paste(frame, picture, left, top, height):
    picture = _high(picture, height)
    frame[top:top + height, left:left + picture.shape[1]] = picture[:, :frame.shape[1] - left]


def _terminal(frame, left, top, width, height, command, output):
    """Draw a terminal that shows the end of the output of a program."""
    terminal = frame[top:top + height, left:left + width]
    terminal[:] = TERMINAL
    printed = [re.sub(r'\x1b\[[0-9;]*m|\[\d+\.\d+(, \d+\.\d+)?\]: ', '', line) for line in output.splitlines()
               if '[INFO]' in line]
    typed = textwrap.wrap(f'$ {command}', 44, subsequent_indent='    ')
    for number, line in enumerate([*typed, *printed[len(typed) - (height - 20) // 20:]]):
        cv2.putText(terminal, line, (10, 24 + 20 * number), FONT, 0.42, PRINTED, 1, cv2.LINE_AA)


def _save(name, picture):
    cv2.imwrite(str(STEPS / f'{name}.png'), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    print(f'{name}.png: {picture.shape[1]} x {picture.shape[0]} px')


def main():
    """Make the pictures that are named."""
    names = sys.argv[1:] or list(MAKERS)
    if set(names) - set(MAKERS):
        sys.exit(f'{" ".join(sorted(set(names) - set(MAKERS)))}: the pictures are {", ".join(MAKERS)}')
    with tempfile.TemporaryDirectory() as folder:
        harness = DemoHarness(folder)
        try:
            harness.open()
            for name in names:
                MAKERS[name](harness)
        finally:
            harness.close()


if __name__ == '__main__':
    main()
