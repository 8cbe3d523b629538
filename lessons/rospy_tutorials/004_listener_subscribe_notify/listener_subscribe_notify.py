#!/usr/bin/env python3
"""Publish on chatter, and notice who subscribes and who leaves."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes


class Friends(rospy.SubscribeListener):
    """Greets new subscribers: all of them, and the new one alone."""

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """Do that; rospy calls this method."""
        print(f'a peer subscribed to topic [{topic_name}]', flush=True)
        for text, publish in (('Hey everyone, we have a new friend!', topic_publish),
                              (f'greetings. welcome to topic {topic_name}', peer_publish)):
            print(text, flush=True)
            publish(String(text))

    def peer_unsubscribe(self, topic_name, num_peers):
        """Say so; rospy calls this method."""
        print(f'a peer unsubscribed from topic [{topic_name}]', flush=True)
        if not num_peers:
            print('I have no friends', flush=True)


def main():
    """Publish until the shutdown."""
    nodes.init_node('talker_callback', anonymous=True)
    publisher = rospy.Publisher('chatter', String, subscriber_listener=Friends(), queue_size=10)
    rate, count = rospy.Rate(10), 0
    while not rospy.is_shutdown():
        text = f'hello world {count}'
        print(text, flush=True)
        publisher.publish(text)
        count += 1
        rate.sleep()


if __name__ == '__main__':
    nodes.run(main)
