"""The node class of the marker trackers, which receives images and publishes poses.

Threading contract: rospy's threads only store the newest image, camera_info and settings, under
``_condition``. One worker thread does everything else: it searches, publishes and sends diagnostics.
"""
import math
import queue
import threading
import time
import traceback

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Bool
from std_srvs.srv import Trigger, TriggerResponse

from alvar_core.camera import CameraError
from alvar_core.detection import explanation
from alvar_core.detection.detector import Detector
from alvar_core.detection.prepared_image import ImageError
from alvar_core.detection.tracker import Tracker
from ar_track_alvar import conversions, settings, start
from ar_track_alvar.conversions import MarkerPose
from ar_track_alvar.core import debug_image
from ar_track_alvar.core.filters import ErrorFilter, RateLimiter, fit_error
from ar_track_alvar.diagnostics import Statistics
from ar_track_alvar.marker_publisher import Report
from ar_track_alvar.settings import AUTO, PARAMETERS, RECTIFIED, LiveSettings
from plain_support import LARGEST_MARKER_ID
from rospy_support import images, parameters, registration, rospy_internals
from rospy_support.throttle import WallThrottle
from rospy_support.topic_diagnosis import COMPRESSED, waiting_text
from rospy_support.topics import LatestPublisher, Publisher

BUFFER = 1 << 22  # [bytes] read from the image connection at once: a colour image of 1280x720
SILENCE = 5.0  # [s] without an image or camera_info before a warning
WARNING_PERIOD = 10.0  # [s] between two warnings of a kind
CHANGED_PERIOD = 1.0  # [s] the same, if the second one names another fault
REPORT = 1.0  # [s] between two reports on /diagnostics
SLOW = 0.05  # [s] between images, from which on each is searched completely, partly after its poses are published
EXPLAIN_TIMEOUT = 5.0  # [s] for an image after a call of ~explain
JUMP_BACK = 1.0  # [s] by which a stamp is older than the last one if time has jumped back


class MarkerNode:
    """Tracks markers and publishes the result of ``to_publish``.

    A node that reports something other than single markers (bundles) derives from this class and overrides
    ``to_publish``; ``sizes`` contains the markers whose size is not ~marker_size.
    """

    def __init__(self, read, sizes=None):
        """Register topics and services; ``read`` are the Settings. ``sizes``: {id: width of the square [m]}."""
        self.settings, self._sizes = read, dict(sizes or {})
        self._condition = threading.Condition()
        self.camera = None  # Camera of the image that is being searched
        self._image = None  # (arrival [s, monotonic], message) of the newest image, until it is searched
        self._searched_image = None  # the message of the image that was searched last
        self._questions = []  # queues, one for each call of ~explain; each gets a TriggerResponse
        self._tracker = self._info = self._camera_key = self._last_stamp = self._subscriber = None
        self._statistics, self._rate, self._errors = Statistics(), RateLimiter(read.max_frequency), ErrorFilter()
        self._simulated = not rospy_internals.is_wall_time()
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._topic = rospy.resolve_name('camera_image')
        self._last_arrival = -math.inf
        self._image_came = self._info_came = self._reported = time.monotonic()
        self._reconfigured = True
        self._report = Report(read.output_frame, read.transform_tolerance, self._statistics, self.complain)
        self._debug = LatestPublisher('~debug_image', Image)
        self._diagnostics = Publisher('/diagnostics', DiagnosticArray, queue_size=1)
        self._explained = Publisher('~explained_image', Image, queue_size=1, latch=True)
        rospy.Service('~explain', Trigger, self._answer)
        self._live = LiveSettings(read, self._settings_changed)
        self._info_subscriber = rospy.Subscriber('camera_info', CameraInfo, self._take_info, queue_size=1,
                                                 tcp_nodelay=True)
        rospy.Subscriber('~enable_detection', Bool, lambda message: self._live.enable(message.data), queue_size=1)
        registration.on_return(self._live.restore)
        parameters.log_effective()

    def to_publish(self, detections):
        """Return the MarkerPoses to publish for the Detections in one image.

        The worker thread calls this for every image that was searched, even without detections; ``camera`` belongs to
        the image. The ids are numbers that fit into a message.
        """
        return [MarkerPose(d.id, d.rotation, d.position, conversions.confidence(d), self.size_of(d.id))
                for d in detections]

    def grey_of(self, message):
        """Return the grey image (height, width) uint8 of a message; raise ImageError."""
        return images.grey(message)

    def bgr_of(self, message):
        """Return the colour image (height, width, 3) uint8 of the message last given to ``grey_of``, a new array."""
        return images.bgr(message).copy()

    def improved(self, detections, _camera):
        """Return the Detections of the image last given to ``grey_of``, possibly with better poses."""
        return detections

    def report_values(self):
        """Return further {key: value} for /diagnostics, and restart the counts."""
        return {}

    def size_of(self, marker_id):
        """Return the width [m] of a marker's black square."""
        return self._sizes.get(marker_id, self.settings.marker_size / 100.0)

    def wait(self):
        """Occupy the main thread until shutdown."""
        rospy.spin()

    def run(self):
        """Work until shutdown."""
        worker = threading.Thread(target=self._work, name='markers', daemon=True)
        worker.start()
        self.wait()
        with self._condition:
            self._condition.notify()
        worker.join(2.0)

    # ------------------------------------------------------------------------------------------- rospy's threads

    def _take_image(self, message):
        now = time.monotonic()
        with self._condition:
            self._image_came = now
            if not self._rate.accept(self._simulated and rospy.get_time() or now):
                self._statistics.skipped += 1
                return
            self._statistics.dropped += self._image is not None
            self._image = now, message
            self._condition.notify()

    def _take_info(self, message):
        with self._condition:
            self._info, self._info_came = message, time.monotonic()

    def _answer(self, _request):
        """Serve ~explain: let the worker thread explain the last image, or the next one if there was none."""
        answer = queue.Queue(1)
        with self._condition:
            self._questions.append(answer)
            self._condition.notify()
        try:
            return answer.get(timeout=EXPLAIN_TIMEOUT)
        except queue.Empty:
            with self._condition:
                self._questions = [each for each in self._questions if each is not answer]
            what = 'image' if self._info is not None else 'camera_info'
            return TriggerResponse(False, f'There was no image to explain within {EXPLAIN_TIMEOUT:.0f} s: no {what} '
                                   'came' + (', because ~enabled is false' if not self.settings.enabled else ''))

    def _settings_changed(self):
        with self._condition:
            self._rate.rate = self.settings.max_frequency
            self._reconfigured = True
            self._condition.notify()

    # ------------------------------------------------------------------------------------------ the worker thread

    def _work(self):
        while not rospy.is_shutdown():
            try:
                self._turn()
            except Exception:  # an error in one image must neither end the tracker nor recur with the next one
                if self._tracker is not None:
                    self._start_anew()
                if not rospy_internals.shutting_down():
                    self.complain('fault', f'Cannot search an image:\n{traceback.format_exc()}')

    def _turn(self):
        """Wait for something to do, and do it."""
        with self._condition:
            asked = self._questions and self._searched_image is not None and self._info is not None
            if self._image is None and not self._reconfigured and not asked:
                rest = self._reported + REPORT - time.monotonic()
                self._condition.wait(max(0.0, self._report.retry or rest))
            image, self._image, info = self._image, None, self._info
            reconfigured, self._reconfigured = self._reconfigured, False
        if reconfigured:
            self._apply_settings()
        if image is not None and self._subscriber is not None:
            self._searched_image = image[1]
            self._search(*image, info)
        if self._questions and self._searched_image is not None and info is not None:
            self._explain(self._searched_image, info)
        self._report.flush()
        if time.monotonic() >= self._reported + REPORT:
            self._report_status()
        if image is not None and self._tracker is not None:
            self._use_spare_time(image[0])

    def _detector(self):
        settings = self.settings
        return Detector(settings.marker_size / 100.0, settings.marker_resolution, settings.marker_margin, self._sizes,
                        settings.gamma or None, settings.max_candidates)

    def _apply_settings(self):
        settings = self.settings
        size = settings.marker_size / 100.0
        if self._tracker is None or self._tracker.detector.size != size:
            detector = self._detector()
            # With simulated time the result must not depend on the available time: search each image completely.
            self._tracker = Tracker(detector) if rospy_internals.is_wall_time() else Tracker(detector, full_every=1)
        if settings.enabled and self._subscriber is None:
            self._image_came = time.monotonic()
            self._start_anew()
            self._subscriber = self.subscribe(self._take_image)
        elif not settings.enabled and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def subscribe(self, callback):
        """Return a Subscriber to the images, which calls ``callback(message)``."""
        if self.settings.image_transport == 'compressed':
            return rospy.Subscriber(self._topic + COMPRESSED, CompressedImage, callback, queue_size=1,
                                    buff_size=BUFFER, tcp_nodelay=True)
        return rospy.Subscriber('camera_image', Image, callback, queue_size=1, buff_size=BUFFER,
                                tcp_nodelay=True)

    def _search(self, arrival, message, info):
        if info is None:
            self._statistics.trouble(f'no camera_info received on {rospy.resolve_name("camera_info")}')
            return
        self._notice_jump(message.header.stamp)
        begun = time.perf_counter()
        try:
            grey = self.grey_of(message)
            camera = self._camera_for(info, grey)
            found = self.improved(self._tracker.update(grey, camera), camera)
        except (CameraError, ImageError, images.ImageError) as error:
            self._statistics.refused += 1
            topic = rospy.resolve_name('camera_info') if isinstance(error, CameraError) else self._topic
            self.complain('input', f'{topic}: {error}', changed=CHANGED_PERIOD)
            return
        self._notice_left_out()
        numbered, others = conversions.numbered(found)
        for content in others:
            self.complain('content', f'A marker with the content {content!r} is visible, but not published: '
                           f'AlvarMarker.id holds only numbers up to {LARGEST_MARKER_ID}.')
        detections = self._errors.accepted(numbered, self.settings.max_new_marker_error,
                                           self.settings.max_track_error)
        self._notice_doubtful(numbered, detections)
        self._statistics.searched(time.perf_counter() - begun, detections)
        self._report.publish(arrival, message.header, self.to_publish(detections))
        if self._debug.wanted():
            drawn = debug_image.draw(self.bgr_of(message), camera, found, detections, self.size_of)
            self._debug.publish(images.to_image(drawn, header=message.header))

    def _notice_doubtful(self, found, accepted):
        """Say why the pose of a marker is doubtful, and that one is not published because of its error."""
        for each in found:
            if each not in accepted:
                limit = f'~max_new_marker_error, {self.settings.max_new_marker_error:g}'
                self.complain('error', f'Marker {each.id} is visible, but not published: its error '
                              f'{fit_error(each):.3f} is above {limit}' + (each.reason and f'; {each.reason}'))
            elif each.reason:
                self.complain('doubtful', f'The orientation of marker {each.id} is doubtful: {each.reason}')

    def _notice_left_out(self):
        left_out, most = self._tracker.detector.left_out, self.settings.max_candidates
        if left_out:
            text = (f'{most + left_out} places in an image may be markers, and ~max_candidates is {most}: they take '
                    'turns from image to image. Set a larger ~max_candidates to search all of them in each')
            self._statistics.trouble(text)
            rospy.logwarn_once('%s', text)

    def _explain(self, message, info):
        """Answer the calls of ~explain: say and draw where the search ended for each candidate in an image."""
        with self._condition:
            questions, self._questions = self._questions, []
        try:
            grey = self.grey_of(message)
            detector = self._detector()  # that of the tracker still has an image
            explained = explanation.explain(detector, grey, self._camera_for(info, grey))
            drawn = explained.draw(self.bgr_of(message))
            self._explained.publish(images.to_image(drawn, header=message.header))
            response = TriggerResponse(True, '\n'.join(
                [*explained.lines, f'Drawn in {rospy.resolve_name("~explained_image")}']))
        except (CameraError, ImageError, images.ImageError) as error:
            response = TriggerResponse(False, f'The last image cannot be searched: {error}')
        for each in questions:
            each.put(response)

    def _use_spare_time(self, arrival):
        """Search the rest of the image that arrived at ``arrival`` [s], if images are rare and no other one waits."""
        apart, self._last_arrival = arrival - self._last_arrival, arrival
        if apart > SLOW and self._image is None:
            self._tracker.search_rest()

    def _camera_for(self, info, grey):
        """Return the Camera of the image; make a new one when camera_info or the size of the image changes."""
        geometry = self.settings.image_geometry
        rectified = geometry == RECTIFIED or geometry == AUTO and self.looks_rectified(info)
        key = conversions.camera_key(info, grey.shape[1], grey.shape[0], rectified)
        if key != self._camera_key:
            self.camera = conversions.camera_of(info, grey.shape[1], grey.shape[0], rectified)
            self._camera_key = key
            rospy.loginfo('Camera: %dx%d, %s', *key[:2], 'rectified: P is used, not D' if rectified else
                          f'distortion model {info.distortion_model or "none"}')
            self._tracker.reset()
        return self.camera

    def looks_rectified(self, _info):
        """Return whether the images are already undistorted; for ~image_geometry auto."""
        return 'rect' in self._topic.rsplit('/', 1)[-1]

    def _notice_jump(self, stamp):
        if self._last_stamp is not None and (self._last_stamp - stamp).to_sec() > JUMP_BACK:
            rospy.loginfo('Time jumped back by %.1f s; tracking starts again', (self._last_stamp - stamp).to_sec())
            self._start_anew()
            self._report.clear()
        self._last_stamp = stamp

    def _start_anew(self):
        self._tracker.reset()
        self._errors.reset()

    # ---------------------------------------------------------------------------------- warnings and diagnostics

    def _report_status(self):
        """Once per second, warn about missing input and publish the diagnostics."""
        now = time.monotonic()
        if self._subscriber is not None:
            with self._condition:
                info, info_came, picture_came = self._info, self._info_came, self._image_came
            if now - picture_came > SILENCE:
                self.complain('picture', f'no image received for {now - picture_came:.0f} s',
                               lambda: waiting_text(self._subscriber, 'camera_image'))
            elif info is None and now - info_came > SILENCE:
                self.complain('camera_info', f'no camera_info received for {now - info_came:.0f} s',
                               lambda: waiting_text(self._info_subscriber, 'camera_info'))
        elapsed, self._reported = now - self._reported, now
        self._diagnostics.publish(self._statistics.report(rospy.get_name(), elapsed, self.settings.enabled,
                                                          rospy.Time.now(), self.report_values()))

    def complain(self, kind, text, more=lambda: '', changed=None):
        """Note a problem and log it with the text of ``more()``; ``kind`` and ``changed``: see WallThrottle.due."""
        self._statistics.trouble(text)
        if self._throttle.due(kind, text, changed):
            rospy.logwarn('%s', '. '.join(filter(None, (text, more()))))


def main():
    """Run individualMarkersNoKinect."""
    start.init_node('individualMarkersNoKinect', PARAMETERS)
    MarkerNode(settings.read()).run()
