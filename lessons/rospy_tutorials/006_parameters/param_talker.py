#!/usr/bin/env python3
"""Read, set, search and delete parameters, and publish one of them."""
import rosgraph
import rospy
from std_msgs.msg import String

from rospy_support import nodes
from rospy_support.parameters import ParameterError

LAUNCH = 'roslaunch rospy_tutorials param_talker.launch'


def read(name):
    """Return a parameter that has to be set, and log it under its full name."""
    resolved = rospy.resolve_name(name)
    try:
        value = rospy.get_param(name)
    except KeyError:
        raise ParameterError(f'parameter {resolved} is not set; {LAUNCH} sets all of them') from None
    rospy.loginfo('%s is %s', resolved, value)
    return value


def change():
    """Set parameters, delete one and search for one."""
    rospy.loginfo('setting parameters...')
    for name, value in (('list_of_floats', [1.0, 2.0, 3.0, 4.0]), ('bool_True', True), ('~private_bar', 1 + 2),
                        ('to_delete', 'baz')):
        rospy.set_param(name, value)
    rospy.loginfo('...parameters have been set')
    if rospy.has_param('to_delete'):
        rospy.delete_param('to_delete')
        rospy.loginfo('deleted %s parameter', rospy.resolve_name('to_delete'))
    else:
        rospy.loginfo('parameter %s was already deleted', rospy.resolve_name('to_delete'))
    rospy.loginfo('found global_example parameter under key: %s', rospy.search_param('global_example'))


def main():
    """Publish the parameter utterance on the topic that ~topic_name names, once a second."""
    nodes.init_node('param_talker')
    read('/global_example')
    utterance, topic = read('utterance'), read('~topic_name')
    rospy.loginfo('%s is %s', rospy.resolve_name('default_param'), rospy.get_param('default_param', 'default_value'))
    gains = rospy.get_param('gains', {})
    if not isinstance(gains, dict) or not {'P', 'I', 'D'} <= gains.keys():
        raise ParameterError(f'parameter {rospy.resolve_name("gains")} is {gains!r}; it must have P, I and D; {LAUNCH} '
                             'sets all of them')
    rospy.loginfo('gains are %s, %s, %s', gains['P'], gains['I'], gains['D'])
    change()
    if not isinstance(topic, str) or not topic or not rosgraph.names.is_legal_name(topic):
        raise ParameterError(f'parameter {rospy.resolve_name("~topic_name")} is {topic!r}; it must be the name of a '
                             'topic, such as chatter. Set it with _topic_name:=chatter')
    publisher, rate = rospy.Publisher(topic, String, queue_size=10), rospy.Rate(1)
    while not rospy.is_shutdown():
        publisher.publish(str(utterance))
        rospy.loginfo('%s', utterance)
        rate.sleep()


if __name__ == '__main__':
    nodes.run(main)
