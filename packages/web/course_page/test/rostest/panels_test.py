#!/usr/bin/env python3
"""The panels of the page that do what rqt does, in a real browser."""
import csv
import glob
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import urllib.request

import cv2
import numpy as np
import rosgraph
import rospkg
import rospy
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped, Twist
from nav_msgs.msg import OccupancyGrid
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_msgs.msg import Int32, String
from std_srvs.srv import Trigger, TriggerResponse

from alvar_core import drawing
from plain_support import course
from rospy_support import images
from rostest_support import browser
from rostest_support.common import DEADLINE, Collected, SimulatorCase, run, skip, until
from rostest_support.node_pages import REPOSITORY

SIZES = (1440, 900, False, False), (844, 390, True, False), (390, 844, True, True)  # width, height [px], touch, dark
ARROW_RIGHT = '\ue014'  # of WebDriver
COURSE = REPOSITORY / 'course'
STEPS, SOLUTION = course.steps(COURSE), COURSE / '01_publish_circle' / 'publish_circle.py'
GRADING = 200.0  # [s] of wall time; an idle machine takes 10
TAB = '\ue004'  # of WebDriver
STOPS = 30  # of the Tab key that are looked at
OPENED = {'course': '?step=0', 'nodes': '?node=/turtlesim', 'topics': '?open=/turtle1/pose'}  # for axe, in each panel
LOOKS = pathlib.Path(__file__).resolve().parents[1] / 'looks.js'
HOSTILE = '<img src=x onerror="document.title=\'broken into\'">\u202e\x07</script>'


class PanelsTest(SimulatorCase):

    @classmethod
    def setUpClass(cls):
        """Start one browser for all tests."""
        port = until(lambda: rospy.get_param('/browser/actual_port', 0), 'the server of the page')
        cls.address = f'http://localhost:{port}/'
        cls.files = tempfile.mkdtemp()
        cls.browser = browser.Browser()
        cls.browser.devtools('Browser.setDownloadBehavior', behavior='allow', downloadPath=cls.files)

    @classmethod
    def tearDownClass(cls):
        """End it."""
        cls.browser.close()
        shutil.rmtree(cls.files, ignore_errors=True)

    def tearDown(self):
        """Look for errors that nobody sees."""
        super().tearDown()
        self.assertEqual([], self.browser.errors())
        self.assertNotIn('broken', self.browser.driver.title)

    def open(self, fragment):
        """Open a panel by its address, on a new page."""
        self.browser.get('about:blank')
        self.browser.get(f'{self.address}#/{fragment}')
        self.until_text(fragment.partition('?')[0].capitalize())

    def looks(self, name, *arguments):
        """Return what a function of looks.js returns."""
        return self.browser.call(LOOKS, f'looks.{name}', *arguments)

    def text(self):
        return self.browser.evaluate('document.querySelector("main").innerText')

    def until_text(self, *texts):
        """Wait until the panel shows all of these."""
        self.browser.until(lambda: all(text in self.text() for text in texts), f'the panel shows {texts}')

    def until_content(self, text):
        """Wait until this is there, perhaps hidden."""
        self.browser.until(lambda: text in self.browser.evaluate('document.querySelector("main").textContent'), text)

    def field(self, label):
        """Return the visible input with this label."""
        def found():
            return next((field for field in self.browser.find('main label')
                         if field.is_displayed() and field.text.strip().startswith(label)), None)
        return self.browser.until(found, f'the field {label}').find_element('css selector', 'input, select, textarea')

    def fill(self, label, text):
        field = self.field(label)
        field.clear()
        field.send_keys(text)
        return field

    def press(self, label, within='main'):
        """Press the visible button with this text or label."""
        def button():
            return next((found for found in self.browser.find(f'{within} button, {within} summary')
                         if found.is_displayed() and label in (found.text.strip(), found.get_attribute('aria-label'))),
                        None)
        self.browser.until(button, f'the button {label}').click()

    def subscribers(self, topic):
        return dict(rosgraph.Master('/test').getSystemState()[1]).get(topic, [])

    def publisher(self, topic, kind, *messages, queue_size=1):
        """Return a publisher that ends with the test; what it publishes at once is latched."""
        publisher = rospy.Publisher(topic, kind, latch=bool(messages), queue_size=queue_size)
        self.addCleanup(publisher.unregister)
        for message in messages:
            publisher.publish(message)
        return publisher

    def collected(self, topic, kind):
        collected = Collected(topic, kind)
        self.addCleanup(collected.subscriber.unregister)
        return collected

    # Each panel

    def test_every_panel_fits_on_a_phone(self):
        self.browser.resize(360, 740, touch=True)
        self.addCleanup(self.browser.resize, 1280, 800)
        self.open('turtle')
        panels = [link.get_attribute('data-id') for link in self.browser.find('#menu a')]
        self.assertGreaterEqual(len(panels), 11)
        for panel in panels:
            self.open(panel)
            self.browser.until(lambda: len(self.text()) > 60, f'{panel} says something')
            self.browser.until(lambda: self.browser.evaluate('document.querySelector("main").scrollWidth') <= 360,
                               f'{panel} fits, once its style sheet has come')

    def test_axe_finds_no_violation(self):
        self.addCleanup(self.browser.resize, 1280, 800)
        self.addCleanup(self.browser.prefer, False)
        for size in SIZES:
            self.look_at(size)
            self.open('turtle')
            for link in self.browser.find('#menu a'):
                panel = link.get_attribute('data-id')
                self.browser.evaluate(f'location.hash = "#/{panel}{OPENED.get(panel, "")}"')
                self.until_text(panel.capitalize())
                self.browser.until(lambda: len(self.text()) > 60, f'{panel} says something')
                self.assertEqual([], self.violations(), f'{panel} at {size[0]} px')
        self.look_at(SIZES[0])
        self.open('topics?beside=nodes,plot,console')
        self.until_text('/turtle1 (3)', 'Nothing to plot yet')
        self.browser.find('.layouts summary')[0].click()
        self.assertEqual([], self.violations(), 'four panels')

    def look_at(self, size):
        width, height, touch, dark = size
        self.browser.resize(width, height, touch)
        self.browser.prefer(dark)

    def violations(self):
        """Return what axe-core finds on the page; skip without it."""
        found = importlib.util.find_spec('axe_core_python')
        if found is None:
            self.skipTest('axe-core is not installed: ./run test installs it')
        if not self.browser.evaluate('"axe" in window'):
            script = pathlib.Path(found.origin).with_name('axe.min.js')
            self.browser.evaluate(script.read_text(encoding='utf-8') + '; void 0')
        return self.looks('violations')

    def test_focus_is_seen_and_nothing_moves_for_whom_that_disturbs(self):
        self.browser.devtools('Emulation.setEmulatedMedia', features=[
            {'name': 'prefers-reduced-motion', 'value': 'reduce'}])
        self.addCleanup(self.browser.prefer, False)
        self.open('turtle')
        stops = []
        for _ in range(STOPS):
            self.browser.driver.switch_to.active_element.send_keys(TAB)
            element, ringed, moving = self.looks('focused')
            self.assertTrue(ringed, f'no ring around {element}')
            self.assertEqual(0, moving)
            stops.append(element)
        self.assertIn('Skip to the panel', stops[0])
        self.assertGreater(len(set(stops)), STOPS - 3)

    def test_a_topic_shows_its_values_until_its_panel_is_left(self):
        self.open('topics')
        self.fill('Filter', 'turtle1 pose')
        self.browser.until(lambda: [row for row in self.browser.find('.row-head') if row.is_displayed()
                                    and '/turtle1/pose' in row.text], 'the topic')[0].click()
        self.until_text('linear_velocity', '5.544445', 'Hz', 'kB/s', '/turtlesim')
        self.assertIn('/browser', self.subscribers('/turtle1/pose'))
        self.assertIn('open=%2Fturtle1%2Fpose', self.browser.driver.current_url)
        self.browser.evaluate('location.hash = "#/nodes"')
        until(lambda: '/browser' not in self.subscribers('/turtle1/pose'), 'the end of the subscription')

    def test_a_message_is_published_by_a_form_and_the_turtle_stops_at_the_end(self):
        velocities = self.collected('/turtle1/cmd_vel', Twist)
        self.open('topics?open=/turtle1/cmd_vel')
        self.press('Publish on this topic')
        for field in ('x', 'Times a second'):
            self.fill(field, 'fast')
        self.press('Publish repeatedly')
        self.until_text('"fast" times a second is not possible')
        self.fill('Times a second', '20')
        self.press('Publish repeatedly')
        self.until_text('"fast" is not a number')
        self.fill('x', '1.5')
        self.press('Publish repeatedly')
        self.assertEqual(1.5, velocities.some(0, 5)[0].linear.x)
        self.until_text('rostopic pub -r 20 /turtle1/cmd_vel geometry_msgs/Twist')
        self.browser.evaluate('location.hash = "#/nodes"')
        until(lambda: velocities.messages[-1] == Twist(), 'a velocity of zero after the panel was left')

    def test_a_hostile_message_is_only_a_text(self):
        self.publisher('/hostile', String, HOSTILE * 10000)
        self.open('topics?open=/hostile')
        self.until_text('<img src=x onerror=', '\\u202e\\u0007</script>')
        self.assertLess(len(self.text()), 5000)

    def test_a_field_is_plotted_and_saved(self):
        self.open('plot')
        self.until_text('Nothing to plot yet')
        self.fill('Field', '/turtle1/pose/x:y:speed\n')
        self.until_text('turtlesim/Pose has no number "speed". It has x, y, theta, linear_velocity')
        self.fill('Field', '/not/yet/there\n')
        self.until_text('no such topic yet')
        self.press('Remove /not/yet/there')
        self.press('Remove /turtle1/pose/speed')
        self.until_text('5.544445')
        self.browser.until(lambda: self.browser.find('.charts canvas'), 'the plot')
        self.driver()(x=1.0)
        self.browser.until(lambda: float(self.browser.find('.legend td:nth-child(4)')[0].text) > 6, 'the turtle drives')
        self.press('Pause')
        self.press('CSV')
        path = os.path.join(self.files, 'plot.csv')
        until(lambda: glob.glob(path), 'the file')
        with open(path, encoding='utf-8') as file:
            rows = list(csv.DictReader(file))
        x = [float(row['/turtle1/pose/x']) for row in rows if row['/turtle1/pose/x']]
        self.assertAlmostEqual(5.544445, x[0], delta=0.01)
        self.assertGreater(max(x), 6.0)
        times = [float(row['time']) for row in rows]
        self.assertEqual(sorted(times), times)
        self.assertIn('fields=%2Fturtle1%2Fpose%2Fx,%2Fturtle1%2Fpose%2Fy', self.browser.driver.current_url)

    def test_a_new_node_appears_in_the_graph_and_goes(self):
        self.open('graph')
        self.browser.until(lambda: '/turtlesim' in self.drawn(), 'turtlesim in the graph')
        self.assertNotIn('/browser', self.drawn())
        self.publisher('/turtle1/cmd_vel', Twist)
        self.browser.until(lambda: rospy.get_name() in self.drawn(), 'this node in the graph')
        self.press('The graph as a table')
        self.until_text('/turtle1/cmd_vel')
        self.looks('chooseInGraph', '/turtlesim')
        self.until_text('Subscribes to /turtle1/cmd_vel')

    def test_the_whole_graph_is_in_its_frame_at_first(self):
        """Also with topics as a camera has them; on a phone, unless it could not be read then."""
        for name in ('/camera/color/image_raw', '/camera/aligned_depth/camera_info', '/turtle1/another_topic'):
            self.publisher(name, String)
        self.addCleanup(self.browser.resize, 1280, 800)
        self.browser.resize(1440, 900)
        self.open('graph')
        self.browser.until(lambda: '/camera/aligned_depth/camera_info' in self.drawn(), 'a topic in the graph')
        self.assertEqual([], self.looks('outsideOfGraph'))
        self.browser.resize(390, 844, touch=True)
        self.press('Fit: show all of it')
        self.browser.until(lambda: not self.looks('outsideOfGraph'), 'all of it')

    def drawn(self):
        return ' '.join(title.get_attribute('textContent') for title in self.browser.find('.graph title'))

    def test_a_service_is_called_by_a_form(self):
        self.open('services?service=/spawn')
        self.fill('x', '1,5')
        self.press('Call')
        self.until_text('Use a point, not a comma: 0.5')
        self.assertEqual('true', self.field('x').get_attribute('aria-invalid'))
        self.fill('x', '1.5')
        self.fill('name', 'it\'s')
        self.press('Call')
        self.until_text('The call failed:')
        self.fill('name', 'Tina')
        self.press('Call')
        self.until_text('Answered in', '"Tina"', 'rosservice call /spawn \'{x: 1.5, y: 0, theta: 0, name: "Tina"}\'')

    def test_a_parameter_is_set_and_deleted(self):
        self.addCleanup(lambda: rospy.has_param('/example') and rospy.delete_param('/example'))
        self.open('parameters')
        self.press('Set a parameter that is not in the list')
        self.fill('Name', '/example')
        self.fill('Value', '[1, 2.5, "a"]\n')
        until(lambda: rospy.get_param('/example', None) == [1, 2.5, 'a'], 'the parameter')
        rospy.set_param('/example', HOSTILE.replace('\x07', ''))
        self.until_text('<img src=x', '\\u202e')
        self.browser.until(lambda: [row for row in self.browser.find('.row-head') if '/example' in row.text],
                           'its row')[0].click()
        self.press('Delete')
        self.assertTrue(rospy.has_param('/example'))
        self.press('Press again to delete')
        until(lambda: not rospy.has_param('/example'), 'the end of the parameter')

    def test_an_arrow_on_the_map_is_a_goal_or_an_estimate(self):
        grid = OccupancyGrid(data=[0] * 100 * 100)
        grid.header.frame_id, grid.info.origin.orientation.w = 'map', 1.0
        grid.info.resolution, grid.info.width, grid.info.height = 0.05, 100, 100  # 5 m x 5 m, its middle at 2.5, 2.5
        self.publisher('/map', OccupancyGrid, grid)
        goals = self.collected('/move_base_simple/goal', PoseStamped)
        estimates = self.collected('/initialpose', PoseWithCovarianceStamped)
        self.open('map')
        self.browser.until(lambda: 'There is no map yet' not in self.text(), 'the map')
        for button, collected in (('2D Nav Goal', goals), ('2D Pose Estimate', estimates)):
            self.press(button)
            self.looks('arrowOnMap')
            until(lambda collected=collected: collected.messages, button)
            pose = collected.messages[0].pose
            self.assertEqual('map', collected.messages[0].header.frame_id)
            pose = getattr(pose, 'pose', pose)
            self.assertAlmostEqual(2.5, pose.position.x, delta=0.02)
            self.assertAlmostEqual(2.5, pose.position.y, delta=0.02)
            self.assertAlmostEqual(0.7071, pose.orientation.z, delta=0.001)  # up on the map: 90 degrees
        self.assertEqual([0.25, 0.25, 0.0685], [estimates.messages[0].pose.covariance[at] for at in (0, 7, 35)])

    def test_log_messages_are_filtered_and_counted(self):
        log = self.publisher('/rosout_agg', Log, queue_size=100)
        until(log.get_num_connections, 'the server, which keeps what was logged before')
        log.publish(Log(level=Log.INFO, name='/talker', msg='before the console'))
        self.open('console')
        self.until_text('before the console')
        def heard():
            log.publish(Log(level=Log.INFO, name='/talker', msg='a beginning'))
            return 'a beginning' in self.text()
        self.browser.until(heard, 'the subscription of the page')
        for _ in range(30):
            log.publish(Log(level=Log.WARN, name='/talker', msg='the same\n' + HOSTILE))
        log.publish(Log(level=Log.ERROR, name='/other', msg='something else'))
        log.publish(Log(level=Log.DEBUG, name='/other', msg='in detail'))
        self.until_text('30 times', 'something else', '<img src=x')
        self.assertNotIn('in detail', self.text())
        self.fill('Text', 'ELSE')
        self.browser.until(lambda: '30 times' not in self.text(), 'the filter')
        self.until_text('something else')
        self.assertIn('text=ELSE', self.browser.driver.current_url)

    def test_pictures_are_shown(self):
        self.open('image?topic=/turtlesim/image_raw')
        self.until_text('500 x 500 pixels')
        self.press('Pause')
        self.browser.find('.image-box canvas')[0].click()
        self.until_text('Pixel x', 'red')
        self.press('Live')
        for hidden in (True, False):  # a browser has six connections for all pages of a server
            self.looks('hide', hidden)
            until(lambda hidden=hidden: ('/browser' in self.subscribers('/turtlesim/image_raw')) != hidden,
                  f'a stream if it is not hidden, {hidden}')
        self.open('image?topic=/nobody/image')
        self.until_text('No node publishes /nobody/image')

    def test_a_window_of_cv2_gets_keys_mouse_and_trackbars(self):
        """The topics of rospy_support's cv2_windows.py; here the test is the program."""
        keys, mouse, low_h = (self.collected(f'/cv_window/w/{name}', kind).messages for name, kind in (
            ('key', String), ('mouse', Point), ('trackbar/Low_H', Int32)))
        image = self.publisher('/cv_window/w', Image)
        trackbars = self.publisher(
            '/cv_window/w/trackbars', String, '[{"name": "Low H", "value": 7, "least": 0, "most": 179}]')
        picture = Image(height=30, width=40, encoding='mono8', step=40, data=bytes(1200))
        self.addCleanup(rospy.Timer(rospy.Duration(0.5), lambda _: image.publish(picture)).shutdown)
        self.open('image?topic=/cv_window/w')
        self.until_text('40 x 30 pixels', 'Low H', '7', 'the keys that you type')
        self.browser.driver.find_element('tag name', 'body').send_keys('q')
        until(lambda: [message.data for message in keys] == ['q'], 'the key')
        self.browser.find('.image-box img')[0].click()
        until(lambda: {message.z for message in mouse} >= {1.0, 4.0}, 'the mouse, pressed and released')
        pressed = next(message for message in mouse if message.z == 1.0)
        self.assertLess(abs(pressed.x - 20) + abs(pressed.y - 15), 3)  # [px] from the middle
        self.browser.find('main input[type=range]')[0].send_keys(ARROW_RIGHT)
        until(lambda: [message.data for message in low_h] == [8], 'the trackbar')
        self.assertEqual(1, len(keys), 'keys for the trackbar are not keys for the program')
        trackbars.publish('no JSON')
        self.browser.until(lambda: not self.browser.find('main input[type=range]'), 'no trackbar')

    def test_a_marker_that_is_not_found_is_explained(self):
        """The tracker's words and picture, those of a photo that is made smaller, and a file that is no photo."""
        line = f'1: its sides are faint {HOSTILE[:60]}'
        tracker = rospy.Service('/tracker/explain', Trigger, lambda request: TriggerResponse(True, line))
        self.addCleanup(tracker.shutdown)
        self.open('markers')
        self.until_text('No tracker runs', 'roslaunch turtle_robotont ar_control.launch')
        self.publisher('/tracker/explained_image', Image, images.to_image(np.full((48, 64, 3), 128, np.uint8)))
        self.press("Explain the camera's image")
        self.until_text('1: its sides are faint <img src=x', 'rosservice call /tracker/explain')
        self.until_picture(64, 48)
        photo = np.full((2400, 3200), 200, np.uint8)
        photo[800:1700, 1000:1900] = np.where(drawing.marker_image(7, 900) > 0, 230, 20)
        path = os.path.join(self.files, 'photo.png')
        cv2.imwrite(path, photo)
        self.field('A photo of your own').send_keys(path)
        self.until_text('The photo has 3200 x 2400 pixels; it was searched at 1600 x 1200.',
                        '1: found as marker 7 (450 px')
        self.until_picture(1600, 1200)
        path = pathlib.Path(self.files, 'no_photo.jpg')
        path.write_text(HOSTILE, encoding='utf-8')
        self.field('A photo of your own').send_keys(str(path))
        self.until_text('This browser cannot read that file as a picture. Save it as a JPEG or PNG')
        self.assertNotIn('marker 7', self.text())

    def until_picture(self, width, height):
        image = 'document.querySelector("main .image-box img")'
        self.browser.until(lambda: self.browser.evaluate(f'[{image}.naturalWidth, {image}.naturalHeight]')
                           == [width, height], f'a picture of {width} x {height}')

    def test_a_course_step_is_marked_when_it_is_seen(self):
        self.open('course?step=1')
        self.until_text(f'0 of {len(STEPS)} steps done', 'rosrun topic_demo publish_circle.py')
        self.publisher('/turtle1/cmd_vel', Twist)
        first, second = (self.browser.find(f'[aria-label="Step {number} is done"]')[0] for number in (1, 2))
        self.browser.until(first.is_selected, 'step 1 is marked')
        self.assertFalse(second.is_selected())
        self.open('course')
        self.until_text('Done')  # it is remembered

    def test_an_address_opens_a_step_and_a_tick_is_remembered(self):
        self.open('course?step=20')
        self.until_text('rostopic echo -n 1 /scan_to_distance')
        self.browser.find('[aria-label="Step 20 is done"]')[0].click()
        self.open('course')
        self.until_text('steps done')
        self.assertTrue(self.browser.find('[aria-label="Step 20 is done"]')[0].is_selected())
        self.assertFalse(self.browser.find('[aria-label="Step 9 is done"]')[0].is_selected())

    def test_what_was_started_elsewhere_is_not_replaced(self):
        """The turtlesim of this test, which shares its launch file with the page."""
        self.open('start')
        self.until_text('runs, started in a terminal')
        self.press('Start Turtlesim')
        self.until_text('"Turtlesim" runs already. It was started together with this page')
        self.assertEqual(1, len(self.browser.errors()))  # the request is refused
        self.assertEqual({'turtle1'}, self.turtles())

    def test_a_recording_is_closed_and_offered(self):
        self.open('start')
        self.until_text('but raw images and point clouds into', 'for at most 10 minutes and')
        folder = pathlib.Path(rospkg.get_ros_home())  # where roslaunch has started the server
        before = set(folder.glob('page_*'))
        self.press('Start Record a bag')
        until(lambda: set(folder.glob('page_*.bag.active')) - before, 'a recording')
        until(lambda: self.subscribers('/turtle1/pose'), 'a recorder')
        self.assertNotIn('/record', ' '.join(self.subscribers('/turtlesim/image_raw')))
        self.press('Stop Record a bag')
        self.until_text('Saved as page_', 'Play page_')
        saved, = set(folder.glob('page_*')) - before
        self.addCleanup(saved.unlink)
        self.assertEqual('.bag', saved.suffix)

    def test_a_program_is_graded_on_a_master_of_its_own(self):
        program = pathlib.Path(rospkg.get_ros_home(), 'my_circle.py')  # where roslaunch has started the server
        self.addCleanup(program.unlink)
        shutil.copy(SOLUTION, program)
        nodes = rosgraph.Master('/test').getSystemState()
        self.open('grade?exercise=publish_circle')
        self.until_text('logs each command', 'my_circle.py')
        self.field('Program').send_keys('my_circle')
        self.press('Grade')
        self.browser.until(lambda: 'passed, 100 of 100' in self.text(), 'the verdict', GRADING)
        self.until_text('40 of 40', f'-- {program}')
        self.assertEqual(nodes[2], rosgraph.Master('/test').getSystemState()[2])
        self.open('grade')
        self.until_text('passed, 100 of 100')  # a new page shows it, too
        self.addCleanup(self.browser.resize, 1280, 800)
        self.addCleanup(self.browser.prefer, False)
        for size in SIZES:
            self.look_at(size)
            self.assertEqual([], self.violations(), f'a verdict at {size[0]} px')

    def test_a_layout_keeps_panels_and_what_they_show(self):
        from selenium.webdriver.support.ui import Select
        self.open('turtle')
        for panel in ('Plot', 'Graph', 'Nodes'):
            Select(self.browser.find('.beside-choice')[0]).select_by_visible_text(panel)
            self.browser.until(lambda panel=panel: panel in self.beside(), panel)
        self.fill('Field', '/turtle1/pose/x\n')
        self.until_text('5.544445')
        self.browser.find('.layouts summary')[0].click()
        self.browser.find('.layouts input')[0].send_keys('mine\n')
        self.press('Close Graph')
        self.browser.until(lambda: 'Graph' not in self.beside(), 'it closes')
        self.open('topics')
        self.browser.find('.layouts summary')[0].click()
        self.browser.until(lambda: [link for link in self.browser.find('.layouts a') if link.text == 'mine'],
                           'the layout')[0].click()
        self.until_text('Turtle', 'Plot', 'Graph', 'Nodes', '5.544445')

    def beside(self):
        return [heading.text for heading in self.browser.find('aside h1')]

    # rqt's programs

    def rqt(self, *command, **environment):
        """Start a program of rqt; return it and the address that it prints."""
        program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   env={**os.environ, 'BROWSER': 'true', **environment})
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.wait, DEADLINE)
        self.addCleanup(program.send_signal, signal.SIGINT)
        lines = iter(program.stdout.readline, '')
        return program, next(line.split()[1] for line in lines if line.startswith('Open '))

    def test_rqt_opens_a_panel_of_the_server_that_runs(self):
        for word, *command in (['/turtle1/pose/y', 'rosrun', 'rqt_plot', 'rqt_plot', '/turtle1/pose/x:y'],
                               ['Ellipses', 'rqt', '-s', 'rqt_graph']):
            program, address = self.rqt(*command)
            self.assertEqual(0, program.wait(DEADLINE))
            self.assertTrue(address.startswith(f'{self.address}#/'), address)
            self.browser.get('about:blank')
            self.browser.get(address)
            self.until_content(word)

    def test_a_second_server_says_where_the_first_is(self):
        """Else the master would end the first one, because both nodes have one name."""
        uri = os.environ['ROS_MASTER_URI'].replace('localhost', '127.0.0.1')
        second = subprocess.run(['rosrun', 'turtle_robotont', 'browser.py', '--port=0'], stdout=subprocess.PIPE,
                                text=True, timeout=DEADLINE, check=True, env={**os.environ, 'ROS_MASTER_URI': uri})
        self.assertIn(f'The page is at {self.address} already', second.stdout)
        self.assertIn('rosnode kill /browser', second.stdout)
        self.assert_first_server_is_there()

    def test_a_server_that_does_not_find_the_first_takes_another_name(self):
        """As on another machine; programs of rqt find it, and the first one stays."""
        port = rospy.get_param('/browser/actual_port')
        self.addCleanup(rospy.set_param, '/browser/actual_port', port)
        rospy.set_param('/browser/actual_port', 1)
        second, address = self.rqt('rosrun', 'turtle_robotont', 'browser.py', '--port=0', '__name:=browser')
        self.assertNotEqual(self.address, address)
        self.assertIn('Another node is called /browser: this one is /browser_', second.stdout.readline())
        third, found = self.rqt('rqt_graph')
        self.assertEqual((0, f'{address}#/graph'), (third.wait(DEADLINE), found))
        self.assert_first_server_is_there()

    def assert_first_server_is_there(self):
        """Assert that the node of the server of this test answers at its address."""
        with urllib.request.urlopen(f'{self.address}status', timeout=DEADLINE) as answer:
            self.assertEqual(rosgraph.Master('/test').lookupNode('/browser'), json.load(answer)['node'])

    def test_rqt_starts_a_server_where_none_runs(self):
        program, address = self.rqt('rqt_graph', ROS_MASTER_URI='http://localhost:1')
        self.assertTrue(address.endswith('#/graph'), address)
        self.assertNotIn(self.address, address)
        with urllib.request.urlopen(address.partition('#')[0], timeout=DEADLINE) as answer:
            self.assertIn(b'id="panels"', answer.read())
        program.send_signal(signal.SIGINT)
        program.wait(DEADLINE)


if __name__ == '__main__':
    if browser.MISSING:
        skip(browser.MISSING)
    else:
        run(PanelsTest)
