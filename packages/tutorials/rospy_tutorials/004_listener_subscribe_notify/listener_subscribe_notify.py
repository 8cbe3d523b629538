#!/usr/bin/env python3
"""Publish on the topic chatter, and notice who subscribes and who leaves."""
import rospy
from std_msgs.msg import String


class Greeter(rospy.SubscribeListener):
    """Greets new subscribers: first all of them, then the new one alone. rospy calls its methods."""

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """Greet a subscriber that has just connected."""
        print(f'a peer subscribed to topic [{topic_name}]')
        text = 'Hey everyone, we have a new friend!'
        print(text)
        topic_publish(String(text))
        text = f'greetings. welcome to topic {topic_name}'
        print(text)
        peer_publish(String(text))

    def peer_unsubscribe(self, topic_name, num_peers):
        """Report that a subscriber has left."""
        print(f'a peer unsubscribed from topic [{topic_name}]')
        if num_peers == 0:
            print('I have no friends')


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('talker_callback', anonymous=True)
    publisher = rospy.Publisher('chatter', String, subscriber_listener=Greeter(), queue_size=10)
    rate = rospy.Rate(10)  # [Hz]
    count = 0
    while not rospy.is_shutdown():
        text = f'hello world {count}'
        print(text)
        publisher.publish(text)
        count += 1
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
