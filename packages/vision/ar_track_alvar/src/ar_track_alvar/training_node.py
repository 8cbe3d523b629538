"""trainMarkerBundle: learn where the markers of a bundle are, from images that each show some of them.

Threading contract: the worker thread of MarkerNode, the threads of services and the main thread, which reads the keys,
all use ``_training`` and its result under ``_lock``. Optimizing holds no lock: it works on a copy of the images.
"""
import os
import select
import sys
import threading
import time

import numpy as np
import rospy
from std_srvs.srv import Trigger, TriggerResponse

from alvar_core import bundles
from alvar_core.detection.bundle_pose import BundleTracker
from alvar_core.detection.bundle_training import Training, TrainingError
from ar_track_alvar import conversions, settings, start
from ar_track_alvar.bundle_node import MASTER, OTHERS
from ar_track_alvar.conversions import MarkerPose
from ar_track_alvar.core import command_line
from ar_track_alvar.node import MarkerNode
from plain_support import LARGEST_MARKER_ID, files
from rospy_support import parameters
from rospy_support.key_terminal import KeyTerminal

AUTO_IMAGES, AUTO_PERIOD = 5, 1.0  # of the key a: images, [s] between them
MAX_AGE = 1.0  # [s] of the last image, so that it can be kept
KEY_PERIOD = 0.1  # [s] between two checks for the shutdown
HELP = """\
Keys:
  p  keep the present image
  a  keep an image a second, for 5 seconds: move the camera or the object meanwhile
  o  optimize: compute where the markers are
  s  save as {file}
  l  load {file}
  r  reset: forget all images and the result
  q  quit
Show the markers from many sides, at least two in each image. Marker {master} is the master."""

NUMBER = parameters.Integer('~nof_markers', 8, 2, 1024)
IDS = parameters.Text('~marker_ids', '')
FILE = parameters.Text('~bundle_file', 'mmarker.xml')
PARAMETERS = parameters.Table(NUMBER, IDS, FILE, settings.PARAMETERS)
EXAMPLE = f'_nof_markers:=8 {command_line.EXAMPLE}'


class TrainingNode(MarkerNode):
    """Publishes the markers that it sees and, once it is known, the bundle under the id of its master."""

    def __init__(self, read, ids, path):
        """``ids`` are the markers of the bundle, the first one is the master; ``path`` is the file to write."""
        self._ids, self._path = ids, os.path.abspath(path)
        self._lock, self._optimizing = threading.Lock(), threading.Lock()
        self._training = Training(ids, read.marker_size / 100.0)
        self._learnt, self._tracker_of_bundle, self._auto = None, None, []
        self._learnable = None  # (time [s, monotonic], detections, camera) of the last image
        super().__init__(read)
        self.commands = {'p': self.capture, 'a': self.capture_some, 'o': self.optimize, 's': self.save, 'l': self.load,
                         'r': self.reset}
        for command in (self.capture, self.optimize, self.save, self.load, self.reset):
            rospy.Service(f'~{command.__name__}', Trigger, lambda _, command=command: TriggerResponse(*command()))

    def to_publish(self, detections):
        """Return the MarkerPoses of all visible markers and, once it is known, of the bundle."""
        now = time.monotonic()
        with self._lock:
            self._learnable = now, detections, self.camera
            tracker, due = self._tracker_of_bundle, bool(self._auto) and now >= self._auto[0]
            if due:
                self._auto.pop(0)
        if due:
            self.capture()
        found = tracker.update(detections, self.camera) if tracker is not None else []
        masters = {one.bundle.master for one in found}
        others = [self._marker_pose(d.id, d, OTHERS) for d in detections if d.id not in masters]
        return others + [self._marker_pose(one.bundle.master, one, MASTER) for one in found]

    def _marker_pose(self, number, found, look):
        return MarkerPose(number, found.rotation, found.position, conversions.confidence(found), self.size_of(number),
                          True, *look)

    def wait(self):
        """Obey the keys until shutdown; without a keyboard, only the services are used."""
        rospy.loginfo('%s', HELP.format(file=self._path, master=self._ids[0]))
        if sys.stdin is not None:
            self._obey_keys()
        rospy.spin()

    def _obey_keys(self):
        with KeyTerminal(sys.stdin.fileno()) as terminal:
            while not rospy.is_shutdown():
                ready, _, _ = select.select([sys.stdin], [], [], KEY_PERIOD)
                data = _read(sys.stdin.fileno()) if ready else None
                if data == b'':
                    break
                for key in (data or b'').decode('ascii', 'ignore').lower():
                    if key == 'q' or terminal.is_terminal and key == '\x04':
                        rospy.signal_shutdown('the key q')
                    elif key in self.commands:
                        self.commands[key]()

    # --------------------------------------------------------------------------- requests of keys and services

    def capture(self):
        """Keep the last image; return (whether it is kept, text)."""
        with self._lock:
            if self._learnable is None or time.monotonic() - self._learnable[0] > MAX_AGE:
                return _said(False, f'No image has been searched within the last {MAX_AGE:g} s; is the camera running?')
            if self._training.size != self.size_of(self._ids[0]):  # dynamic_reconfigure has changed it
                self._training = Training(self._ids, self.size_of(self._ids[0]))
            try:
                view = self._training.add(*self._learnable[1:])
            except TrainingError as error:
                return _said(False, f'This image is not kept: {error}.')
            count, missing = len(self._training.views), self._training.missing()
        return _said(True, ' '.join([f'Image {count} is kept: markers {", ".join(map(str, sorted(view.markers)))}.',
                                     *missing]))

    def capture_some(self):
        """Keep five images, one a second."""
        with self._lock:
            self._auto = [time.monotonic() + AUTO_PERIOD * number for number in range(AUTO_IMAGES)]
        return _said(True, f'{AUTO_IMAGES} images follow, one each {AUTO_PERIOD:g} s.')

    def optimize(self):
        """Compute the bundle; on failure keep the previous result. Return (success, text)."""
        if not self._optimizing.acquire(blocking=False):
            return _said(False, 'It is being optimized already.')
        try:
            with self._lock:
                training = Training(self._training.ids, self._training.size)
                training.views = list(self._training.views)
            learnt = training.solve()
        except TrainingError as error:
            return _said(False, f'Not optimized: {error}')
        finally:
            self._optimizing.release()
        self._use(learnt.bundle(self._path), learnt)
        lines = [f'Learnt from {learnt.views} images; corners fit within {learnt.error:.2f} px:']
        for number, spread in learnt.spread.items():
            if number != self._ids[0]:
                lines.append(f'  marker {number}: position +-{1e3 * spread.position:.2f} mm, rotation '
                             f'+-{np.degrees(spread.rotation):.2f} degrees')
        return _said(True, '\n'.join([*lines, *learnt.notes]), not learnt.notes)

    def save(self):
        """Write the bundle to the file; return (success, text)."""
        with self._lock:
            learnt = self._learnt
        if learnt is None:
            return _said(False, 'Nothing is saved, because nothing is learnt: keep images (p), then optimize (o).')
        try:
            if os.path.lexists(self._path):
                bundles.read(self._path)  # raises an error for a file that is not a bundle, which is not overwritten
            files.write_whole(self._path, bundles.xml(learnt.corners, learnt.unknown))
        except bundles.BundleError as error:
            return _said(False, f'Not saved, because this would overwrite something else: {error}. Choose another '
                                'file with ~bundle_file.')
        except OSError as error:
            return _said(False, f'Not saved: {files.unwritten(error, "choose another file with ~bundle_file")}.')
        unknown = f' The position of {", ".join(map(str, learnt.unknown))} is not known.' if learnt.unknown else ''
        return _said(True, f'Saved: {self._path}, {len(learnt.corners)} markers.{unknown}', not unknown)

    def load(self):
        """Read the bundle from the file, to check it; keep the images. Return (success, text)."""
        try:
            bundle = bundles.read(self._path)
        except bundles.BundleError as error:
            return _said(False, f'Not loaded: {error}.')
        self._use(bundle, None)
        return _said(True, f'Loaded: {self._path}, markers {", ".join(map(str, bundle.corners))}.')

    def reset(self):
        """Forget the images and the result; keep the file."""
        with self._lock:
            self._training = Training(self._ids, self.settings.marker_size / 100.0)
            self._learnt, self._tracker_of_bundle, self._auto = None, None, []
        return _said(True, 'All images and the result are forgotten.')

    def _use(self, bundle, learnt):
        with self._lock:
            self._learnt, self._tracker_of_bundle = learnt, BundleTracker([bundle])


def _said(success, text, well=True):
    (rospy.loginfo if success and well else rospy.logwarn)('%s', text)
    return success, text


def _read(descriptor):
    try:
        return os.read(descriptor, 1024)
    except OSError:  # the terminal was closed
        return b''


def read_ids():
    """Return the ids of the bundle's markers, the master first; raise ParameterError."""
    words = IDS.read().replace(',', ' ').split()
    if not words:
        return list(range(NUMBER.read()))
    ids = [int(word) for word in words if word.isascii() and word.isdigit() and int(word) <= LARGEST_MARKER_ID]
    if len(ids) != len(words) or len(set(ids)) != len(ids) or len(ids) < 2:
        raise parameters.ParameterError(
            f'parameter {rospy.resolve_name(IDS.name)} is {IDS.read()!r}: at least two different numbers from 0 to '
            f'{LARGEST_MARKER_ID} are needed, separated by spaces; the first one is the master')
    return ids


def main():
    """Run trainMarkerBundle."""
    start.init_node('trainMarkerBundle', PARAMETERS, command_line.TRAINING_USAGE, command_line.training_arguments,
                    EXAMPLE)
    TrainingNode(settings.read(), read_ids(), FILE.read()).run()
