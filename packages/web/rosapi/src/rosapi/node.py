"""rosapi_node: the services of rosapi.

Threading contract: rospy answers each call in a thread of its own.
"""
import functools

import rospy

import rosapi.srv
from browser_servers.rosapi_answers import NAMESPACE, Answers
from rosapi.msg import TypeDef
from rospy_support import nodes
from rospy_support.parameters import Table, Text

PARAMETERS = Table(Text('~topics_glob', '[*]'), Text('~services_glob', '[*]'), Text('~params_glob', '[*]'))


def main() -> None:
    nodes.init_node('rosapi_node', PARAMETERS)
    answers = Answers(rosapi.srv, TypeDef, *PARAMETERS.read())
    for name, service in answers.services.items():
        rospy.Service(f'{NAMESPACE}{name}', service, functools.partial(answers.call, name))
    rospy.loginfo('Rosapi started')
    rospy.spin()
