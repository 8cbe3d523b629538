#!/usr/bin/env python3
"""web_video_server from outside: its answers to a browser."""
import http.client

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from rospy_support.images import to_compressed, to_image
from rostest_support.common import DEADLINE, SimulatorCase, run, until

NODE, TOPIC = '/web_video_server', '/camera/image_raw'
LOSSY = 6  # error of a colour value in JPEG


def plain(green):
    """Return an image of one colour; BGR."""
    return np.full((48, 64, 3), (10, green, 20), np.uint8)


class WebVideoTest(SimulatorCase):

    def setUp(self):
        """Publish an image; no simulator is needed."""
        until(lambda: rospy.has_param(f'{NODE}/actual_port'), 'the server')
        self.port = rospy.get_param(f'{NODE}/actual_port')
        self.image = rospy.Publisher(TOPIC, Image, latch=True, queue_size=1)
        self.image.publish(to_image(plain(200), 'bgr8'))
        self.compressed = rospy.Publisher(f'{TOPIC}/compressed', CompressedImage, latch=True, queue_size=1)
        self.compressed.publish(to_compressed(plain(100)))
        self.addCleanup(self.image.unregister)
        self.addCleanup(self.compressed.unregister)

    def get(self, path, **headers):
        """Return the answer to a request."""
        connection = http.client.HTTPConnection('localhost', self.port, timeout=DEADLINE)
        self.addCleanup(connection.close)
        connection.request('GET', path, headers=headers)
        answer = connection.getresponse()
        answer.end = connection.close
        return answer

    def assert_green(self, data, green):
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
        self.assertLessEqual(np.abs(picture.astype(int) - plain(green)).max(), LOSSY)

    def test_topics_are_listed(self):
        answer = self.get('/')
        self.assertEqual(200, answer.status)
        self.assertIn('/snapshot?topic=%2Fcamera%2Fimage_raw', answer.read().decode())
        page = self.get(f'/stream_viewer?topic={TOPIC}&type=png').read().decode()
        self.assertIn(f'<img src="/stream?topic={TOPIC}&amp;type=png"', page)

    def test_snapshot_in_all_kinds(self):
        for kind, content, green in (('mjpeg', 'image/jpeg', 200), ('png', 'image/png', 200),
                                     ('ros_compressed', 'image/jpeg', 100)):
            answer = self.get(f'/snapshot?topic={TOPIC}&type={kind}')
            self.assertEqual((200, content), (answer.status, answer.getheader('Content-Type')))
            self.assert_green(answer.read(), green)

    def test_images_are_compressed_here_where_nobody_else_does(self):
        """As in the Robotont's own page, which asks for ros_compressed from a camera that may not have it."""
        raw = rospy.Publisher('/raw_only', Image, latch=True, queue_size=1)
        raw.publish(to_image(plain(150), 'bgr8'))
        self.addCleanup(raw.unregister)
        answer = self.get('/snapshot?topic=/raw_only&type=ros_compressed')
        self.assertEqual((200, 'image/jpeg'), (answer.status, answer.getheader('Content-Type')))
        self.assert_green(answer.read(), 150)

    def test_a_latched_image_is_there_for_every_viewer(self):
        """It comes once: a snapshot waited in vain for the next one while a stream showed it."""
        latched = rospy.Publisher('/latched', Image, latch=True, queue_size=1)
        latched.publish(to_image(plain(90), 'bgr8'))
        self.addCleanup(latched.unregister)
        stream = self.get('/stream?topic=/latched')
        self.assertEqual(b'--boundarydonotcross\r\n', stream.readline())
        self.assertEqual(b'Content-Type: image/jpeg\r\n', stream.readline())
        self.assert_green(self.get('/snapshot?topic=/latched').read(), 90)
        stream.close()

    def test_stream_shows_the_newest_image(self):
        streams = [self.get(f'/stream?topic={TOPIC}') for _ in range(3)]
        for green in (200, 60):
            for stream in streams:
                self.assertEqual(b'--boundarydonotcross\r\n', stream.readline())
                headers = dict(iter(lambda one=stream: one.readline().strip().split(b': '), [b'']))
                self.assertEqual(b'image/jpeg', headers[b'Content-Type'])
                self.assert_green(stream.read(int(headers[b'Content-Length'])), green)
                self.assertEqual(b'\r\n', stream.readline())
            self.image.publish(to_image(plain(60), 'bgr8'))
        for stream in streams:
            stream.end()
            stream.close()
        until(lambda: not self.image.get_num_connections(), 'the end of the subscription')

    def test_images_come_one_after_the_other_where_a_proxy_passes_on_no_stream(self):
        """Each is the newest after the last one; one that is numbered by another server is no reason to wait."""
        address = f'/snapshot?topic={TOPIC}&after='
        first = self.get(address + '0')
        self.assert_green(first.read(), 200)
        for after in ('999999', 'none', '9' * 30):
            self.assert_green(self.get(address + after).read(), 200)
        self.assertEqual(1, self.image.get_num_connections())  # it stays subscribed in between
        self.image.publish(to_image(plain(60), 'bgr8'))
        second = self.get(address + first.getheader('Image-Number'))
        self.assert_green(second.read(), 60)
        self.assertGreater(int(second.getheader('Image-Number')), int(first.getheader('Image-Number')))
        until(lambda: not self.image.get_num_connections(), 'the end of the subscription')

    def test_wrong_addresses_are_answered(self):
        broken = rospy.Publisher('/broken', Image, latch=True, queue_size=1)
        broken.publish(Image(width=9, height=9, encoding='nonsense'))
        for path, status, error in (
                ('/stream', 400, 'needs the topic'),
                (f'/stream?topic={TOPIC}&type=vp9', 400, 'type=vp9 is not supported'),
                ('/nope', 404, 'there are /, /stream'),
                ('/snapshot?topic=/broken', 415, "encoding 'nonsense' is unknown")):
            answer = self.get(path)
            self.assertEqual(status, answer.status, path)
            self.assertIn(error, answer.read().decode())

    def test_foreign_pages_are_refused(self):
        for headers in ({'Origin': 'http://evil.example'}, {'Host': 'evil.example'}):
            self.assertEqual(403, self.get(f'/snapshot?topic={TOPIC}', **headers).status)
        answer = self.get(f'/snapshot?topic={TOPIC}', Origin='http://localhost:9000')
        self.assertEqual((200, 'http://localhost:9000'),
                         (answer.status, answer.getheader('Access-Control-Allow-Origin')))


if __name__ == '__main__':
    run(WebVideoTest)
