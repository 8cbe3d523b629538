"""rosapi_node: the services of rosapi.

Threading contract: rospy answers each call in a thread of its own.
"""
import functools

import rospy

from rosapi.answers import NAMESPACE, SERVICES, Answers
from rospy_support import nodes
from rospy_support.parameters import Table, Text

PARAMETERS = Table(Text('~topics_glob', '[*]'), Text('~services_glob', '[*]'), Text('~params_glob', '[*]'))


def main():
    """Serve until shutdown."""
    nodes.init_node('rosapi_node', PARAMETERS)
    answers = Answers(*PARAMETERS.read())
    for name, service in SERVICES.items():
        rospy.Service(f'{NAMESPACE}{name}', service, functools.partial(answers.call, name))
    rospy.loginfo('Rosapi started')
    rospy.spin()
