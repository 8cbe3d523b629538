#!/usr/bin/env python3
"""rosbridge_websocket from outside: the protocol between a WebSocket client and nodes of ROS, and refusals."""
import collections
import http.client
import json
import math
import threading

import cbor2
import rospy
from geometry_msgs.msg import PointStamped, Twist
from sensor_msgs.msg import Image
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool
from turtlesim.msg import Pose

from rostest_support.common import DEADLINE, Collected, SimulatorCase, proxy, run, until
from rostest_support.websocket_client import Ended, WebSocket

NODE = '/rosbridge_websocket'


class Client(WebSocket):
    """A client that reads the server's operations one by one."""

    def __init__(self, port, **headers):
        super().__init__(('localhost', port), DEADLINE, headers.items())
        self._frames = collections.deque()

    def next(self, op=None):
        """Return the next operation, of this kind if one is given."""
        while True:
            while not self._frames:
                self._frames.extend(self.frames())
            frame = self._frames.popleft()
            operation = json.loads(frame) if frame.startswith(b'{') else cbor2.loads(frame)
            if op in (None, operation['op']):
                return operation

    def call(self, service, /, **arguments):
        """Return the response of a service."""
        self.send(op='call_service', service=service, args=arguments)
        return self.next('service_response')


class RosbridgeTest(SimulatorCase):

    def setUp(self):
        """Find the server."""
        super().setUp()
        until(lambda: rospy.has_param(f'{NODE}/actual_port'), 'the server')
        self.port = rospy.get_param(f'{NODE}/actual_port')

    def client(self, **headers):
        """Return a client that is connected."""
        client = Client(self.port, **headers)
        self.addCleanup(client.close)
        return client

    def page(self, path, **headers):
        """Return status and text of a page."""
        connection = http.client.HTTPConnection('localhost', self.port, timeout=DEADLINE)
        self.addCleanup(connection.close)
        connection.putrequest('GET', path, skip_host='Host' in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.read()

    def test_messages_in_all_encodings(self):
        publisher = rospy.Publisher('/numbers', PointStamped, latch=True, queue_size=1)
        message = PointStamped()
        message.point.x, message.point.y = math.nan, 0.5
        publisher.publish(message)
        for compression in ('none', 'png', 'cbor', 'cbor-raw'):
            client = self.client()
            client.send(op='subscribe', topic='/numbers', compression=compression, fragment_size=50)
            if compression in ('cbor', 'cbor-raw'):
                received = client.next('publish')['msg']
            else:
                parts = [client.next('fragment')]
                parts += [client.next('fragment') for _ in range(parts[0]['total'] - 1)]
                received = json.loads(''.join(part['data'] for part in parts))
            if compression == 'none':
                self.assertEqual({'x': None, 'y': 0.5, 'z': 0.0}, received['msg']['point'])
            elif compression == 'png':
                self.assertEqual('png', received['op'])
            elif compression == 'cbor':
                self.assertTrue(math.isnan(received['point']['x']) and received['point']['y'] == 0.5)
            else:
                self.assertEqual(0.5, PointStamped().deserialize(received['bytes']).point.y)

    def test_types_are_found_out_and_compared(self):
        client = self.client()
        client.send(op='subscribe', topic='/later')
        client.send(op='publish', topic='/nobody', msg={})
        self.assertIn('the type of /nobody is not known', client.next('status')['msg'])
        publisher = rospy.Publisher('/later', Float64, queue_size=1)
        until(publisher.get_num_connections, 'the subscriber')
        publisher.publish(2.5)
        self.assertEqual({'data': 2.5}, client.next('publish')['msg'])
        for operation in ('subscribe', 'advertise'):
            client.send(op=operation, topic='/turtle1/pose', type='std_msgs/String')
            self.assertIn('of /turtle1/pose is turtlesim/Pose, not std_msgs/String', client.next('status')['msg'])
        client.send(op='advertise', topic='/x', type='nope/Nope')
        self.assertIn("the message type 'nope/Nope' is not installed here", client.next('status')['msg'])

    def test_latched_message_reaches_later_clients(self):
        publisher = rospy.Publisher('/map_name', String, latch=True, queue_size=1)
        publisher.publish('maze')
        for _ in range(3):
            client = self.client()
            client.send(op='subscribe', topic='/map_name', type='std_msgs/String')
            self.assertEqual({'data': 'maze'}, client.next('publish')['msg'])

    def test_calls_in_both_directions(self):
        client, other = self.client(), self.client()
        self.assertEqual({'op': 'service_response', 'service': '/spawn', 'values': {'name': 'leo'}, 'result': True},
                         client.call('/spawn', x=1, y=2, theta=0, name='leo'))
        refused = client.call('/spawn', x='here')
        self.assertFalse(refused['result'])
        self.assertIn("x is 'here'; it must be a number", refused['values'])
        client.send(op='advertise_service', service='/lamp', type='std_srvs/SetBool')
        until(lambda: other.call('/rosapi/service_type', service='/lamp')['values']['type'], 'the service')
        answers = []
        threading.Thread(target=lambda: answers.append(proxy('/lamp', SetBool)(True)), daemon=True).start()
        request = client.next('call_service')
        self.assertEqual(('/lamp', {'data': True}), (request['service'], request['args']))
        client.send(op='service_response', service='/lamp', id=request['id'], result=True,
                    values={'success': True, 'message': 'on'})
        until(lambda: answers, 'the answer')
        self.assertEqual('on', answers[0].message)
        other.send(op='call_service', service='/lamp', args={'data': False})
        client.send(op='service_response', service='/lamp', id=client.next('call_service')['id'], result=False,
                    values={'success': True})  # an answer with fields is one, as in the original
        self.assertEqual({'success': True, 'message': ''}, other.next('service_response')['values'])
        other.send(op='call_service', service='/lamp', args={'data': False})
        client.send(op='service_response', service='/lamp', id=client.next('call_service')['id'], result=False,
                    values='broken')
        self.assertIn('broken', other.next('service_response')['values'])
        other.send(op='call_service', service='/lamp', args={'data': False})
        client.next('call_service')
        client.close()  # whoever calls must not wait for ever
        response = other.next('service_response')
        self.assertFalse(response['result'])
        self.assertIn('does not answer /lamp any more', response['values'])

    def test_rosapi_tells_what_there_is(self):
        client = self.client()
        values = client.call('/rosapi/topics')['values']
        self.assertEqual('turtlesim/Pose', dict(zip(values['topics'], values['types']))['/turtle1/pose'])
        self.assertIn('/turtlesim', client.call('/rosapi/nodes')['values']['nodes'])
        self.assertIn('/spawn', client.call('/rosapi/services_for_type', type='turtlesim/Spawn')['values']['services'])
        for service in ('/spawn', 'turtlesim/Spawn'):
            providers = client.call('/rosapi/service_providers', service=service)['values']['providers']
            self.assertEqual(['/turtlesim'], providers, service)
        publishers = client.call('/rosapi/publishers', topic='/turtle1/pose')['values']['publishers']
        self.assertEqual(['/turtlesim'], publishers)
        self.assertIn('float32 x', client.call('/rosapi/topics_and_raw_types')['values']['typedefs_full_text'][
            values['topics'].index('/turtle1/pose')])
        typedefs = client.call('/rosapi/message_details', type='geometry_msgs/Twist')['values']['typedefs']
        self.assertEqual(['geometry_msgs/Twist', 'geometry_msgs/Vector3'], [typedef['type'] for typedef in typedefs])
        client.call('/rosapi/set_param', name='/rosbridge_test', value='{"a": [1, 2]}')
        value = client.call('/rosapi/get_param', name='/rosbridge_test')['values']['value']
        self.assertEqual({'a': [1, 2]}, json.loads(value))
        tree = json.loads(client.call('/rosapi/get_param', name='/')['values']['value'])
        self.assertEqual({'a': [1, 2]}, tree.get('rosbridge_test'))
        client.call('/rosapi/delete_param', name='/rosbridge_test')
        for default in ('default', 'default_value'):  # the name in ROS 1, and in ROS 2
            self.assertEqual('5', client.call('/rosapi/get_param', name='/rosbridge_test',
                                              **{default: '5'})['values']['value'])
        typedefs = client.call('/rosapi/message_details', type='geometry_msgs/msg/Twist')['values']['typedefs']
        self.assertEqual('geometry_msgs/Twist', typedefs[0]['type'])
        self.assertIn('is not valid JSON', client.call('/rosapi/set_param', name='/a', value='text')['values'])
        details = client.call('/rosapi/node_details', node='/turtlesim')['values']
        self.assertIn('/turtle1/cmd_vel', details['subscribing'])

    def test_deadman_stops_the_turtle(self):
        velocities, poses = Collected('/turtle1/cmd_vel', Twist), Collected('/turtle1/pose', Pose)
        for leaves in (True, False):
            client, start = self.client(), len(velocities.messages)
            client.send(op='deadman', timeout=0.5)
            client.send(op='advertise', topic='/turtle1/cmd_vel', type='geometry_msgs/Twist')
            client.send(op='publish', topic='/turtle1/cmd_vel', msg={'linear': {'x': 1.0}})
            driving = velocities.index(lambda twist: twist.linear.x == 1.0, 'the velocity', start)
            if leaves:
                client.close()
            velocities.index(lambda twist: twist.linear.x == 0.0, 'the zero velocity', driving)
            poses.next(lambda pose: pose.linear_velocity == 0.0, 'the turtle standing')

    def test_client_that_reads_nothing_delays_nobody(self):
        publisher = rospy.Publisher('/images', Image, queue_size=1)
        self.client().subscribe('/images', 'sensor_msgs/Image')
        until(publisher.get_num_connections, 'the subscription')
        good = self.client()
        good.send(op='subscribe', topic='/images', throttle_rate=1)
        good.call('/rosapi/get_time')  # the subscription came before it
        image = Image(width=640, height=480, step=1920, data=b'\x42' * 921600)
        for number in range(30):
            image.header.seq = number
            publisher.publish(image)
            self.assertEqual(640, good.next('publish')['msg']['width'])

    def test_foreign_pages_are_refused(self):
        for headers in ({'Origin': 'http://evil.example'}, {'Host': 'evil.example'}):
            with self.assertRaises(Ended) as refused:
                self.client(**headers)
            self.assertEqual(403, refused.exception.code)
            self.assertEqual(403, self.page('/browser.png', **headers)[0])
        self.assertTrue(self.client(Origin='http://localhost:8000').call('/rosapi/get_time')['result'])
        status, data = self.page('/browser.png')
        self.assertEqual((200, b'\x89PNG'), (status, data[:4]))


if __name__ == '__main__':
    run(RosbridgeTest)
