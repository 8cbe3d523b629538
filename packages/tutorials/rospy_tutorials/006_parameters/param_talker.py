#!/usr/bin/env python3
"""Read, set, search for and delete parameters, and publish one of them."""
import sys

import rospy
from std_msgs.msg import String


def read():
    """Return what to publish and on which topic, and log all parameters that are read."""
    rospy.loginfo('%s is %s', rospy.resolve_name('/global_example'), rospy.get_param('/global_example'))
    utterance = rospy.get_param('utterance')  # in the namespace of the node
    rospy.loginfo('%s is %s', rospy.resolve_name('utterance'), utterance)
    topic_name = rospy.get_param('~topic_name')  # private: in the namespace that is the name of the node
    rospy.loginfo('%s is %s', rospy.resolve_name('~topic_name'), topic_name)
    default = rospy.get_param('default_param', 'default_value')  # with a default, which is used if it is not set
    rospy.loginfo('%s is %s', rospy.resolve_name('default_param'), default)
    gains = rospy.get_param('gains')  # a namespace is a dictionary
    rospy.loginfo('gains are %s, %s, %s', gains['P'], gains['I'], gains['D'])
    return utterance, topic_name


def change():
    """Set parameters, delete one and search for one."""
    rospy.loginfo('setting parameters...')
    rospy.set_param('list_of_floats', [1.0, 2.0, 3.0, 4.0])
    rospy.set_param('bool_True', True)
    rospy.set_param('~private_bar', 1 + 2)
    rospy.set_param('to_delete', 'baz')
    rospy.loginfo('...parameters have been set')
    if rospy.has_param('to_delete'):
        rospy.delete_param('to_delete')
        rospy.loginfo('deleted %s parameter', rospy.resolve_name('to_delete'))
    rospy.loginfo('found global_example parameter under key: %s', rospy.search_param('global_example'))


def main():
    """Publish the parameter utterance on the topic that ~topic_name names, once a second."""
    rospy.init_node('param_talker')
    try:
        utterance, topic_name = read()
    except KeyError as error:
        sys.exit(f'The parameter {error} is not set. Type: roslaunch rospy_tutorials param_talker.launch')
    change()
    publisher = rospy.Publisher(topic_name, String, queue_size=10)
    rate = rospy.Rate(1)  # [Hz]
    while not rospy.is_shutdown():
        publisher.publish(utterance)
        rospy.loginfo(utterance)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
