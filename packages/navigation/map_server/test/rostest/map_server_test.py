#!/usr/bin/env python3
"""map_server publishes a map and answers about it; map_saver writes the same file again."""
import os
import shutil
import subprocess
import tempfile
import unittest

import roslib.packages
import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, LoadMap

from rospy_support.rotations import yaw_of
from rostest_support.common import DEADLINE, proxy, run

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'data')
CELLS = (100, 0, -1, 0, 100, -1)  # the image's rows, the lowest first


class MapServerTest(unittest.TestCase):

    def program(self, name, *arguments, **options):
        """Run a program of map_server; return it when it has ended."""
        return subprocess.run([roslib.packages.find_node('map_server', name)[0], *arguments], capture_output=True,
                              text=True, timeout=DEADLINE, check=False, **options)

    def test_map_is_published_and_served(self):
        message = rospy.wait_for_message('map', OccupancyGrid, DEADLINE)
        self.assertEqual(CELLS, message.data)
        self.assertEqual(('map', 3, 2), (message.header.frame_id, message.info.width, message.info.height))
        self.assertAlmostEqual(0.1, message.info.resolution, 6)
        origin = message.info.origin
        self.assertEqual((-1.0, 2.0), (origin.position.x, origin.position.y))
        self.assertAlmostEqual(0.5, yaw_of(origin.orientation))
        self.assertEqual(message.info, rospy.wait_for_message('map_metadata', MapMetaData, DEADLINE))
        self.assertEqual(CELLS, proxy('static_map', GetMap)().map.data)

    def test_saved_map_is_the_file_that_was_read(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        saved = self.program('map_saver', '-f', 'turned', cwd=folder)
        self.assertEqual(0, saved.returncode, saved.stderr)
        with open(os.path.join(DATA, 'turned.pgm'), 'rb') as first, open(f'{folder}/turned.pgm', 'rb') as second:
            self.assertEqual(first.read(), second.read())
        with open(f'{folder}/turned.yaml', encoding='utf-8') as file:
            self.assertEqual('image: turned.pgm\nresolution: 0.100000\norigin: [-1.000000, 2.000000, 0.500000]\n'
                             'negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n\n', file.read())

    def test_a_map_of_the_same_name_is_kept_and_can_be_loaded(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        for name in ('turned.yaml', 'turned.pgm'):
            shutil.copy(os.path.join(DATA, name), folder)
        with open(f'{folder}/turned.pgm', 'r+b') as file:
            file.seek(-1, os.SEEK_END)
            file.write(b'\0')  # the cell in the last corner is occupied
        saved = self.program('map_saver', '-f', f'{os.path.basename(folder)}/turned', cwd=os.path.dirname(folder))
        self.assertEqual(0, saved.returncode, saved.stderr)
        self.assertIn('it is now called', saved.stdout + saved.stderr)
        self.assertEqual({'turned.yaml', 'turned.pgm', 'turned_2.yaml', 'turned_2.pgm'}, set(os.listdir(folder)))
        change = proxy('change_map', LoadMap)
        self.addCleanup(change, os.path.join(DATA, 'turned.yaml'))
        self.assertEqual(100, change(f'{folder}/turned_2.yaml').map.data[2])
        self.assertEqual(CELLS, change(f'{folder}/turned.yaml').map.data)

    def test_a_folder_that_is_missing_is_named_with_what_to_type(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        ended = self.program('map_saver', '-f', 'maps/mymap', cwd=folder)
        self.assertEqual(1, ended.returncode)
        self.assertIn(f'{folder}/maps/mymap.pgm cannot be written: No such file or directory. Type mkdir -p {folder}'
                      '/maps, or choose another folder: -f FOLDER/NAME', ended.stderr)
        self.assertEqual([], os.listdir(folder))

    def test_map_is_changed_only_for_a_good_one(self):
        change = proxy('change_map', LoadMap)
        self.assertEqual(1, change('/no/such.yaml').result)
        self.assertEqual(2, change(os.path.join(DATA, 'turned.pgm')).result)
        good = change(os.path.join(DATA, 'turned.yaml'))
        self.assertEqual((0, CELLS), (good.result, good.map.data))

    def test_wrong_files_and_options_end_it_with_a_text(self):
        for program, arguments, said in (
                ('map_server', ['/no/such.yaml'], 'could not open /no/such.yaml: No such file'),
                ('map_server', [], 'usage: rosrun map_server map_server MAP.yaml'),
                ('map_saver', ['--occ', '200'], '200 must be between 1 and 100'),
                ('map_saver', ['--free', '70'], '--free 70 must be smaller than --occ 65')):
            ended = self.program(program, *arguments)
            self.assertNotEqual(0, ended.returncode)
            self.assertIn(said, ended.stdout + ended.stderr)
            self.assertNotIn('Traceback', ended.stderr)


run(MapServerTest)
