"""Explain why no message arrives on a topic: which nodes publish it, and which other topics have its type."""
import xmlrpc.client
from typing import Mapping, Sequence

import rosgraph
import rospy

COMPRESSED = '/compressed'  # the suffix that image_transport appends to an image topic


def waiting_text(subscriber: rospy.Subscriber, name: str) -> str:
    """Return a text that explains why a rospy.Subscriber gets no message; ``name`` is its topic before remapping."""
    topic, data_type = subscriber.resolved_name, subscriber.type
    try:
        master = rosgraph.Master(rospy.get_name())
        types = dict(master.getTopicTypes())
        publishers = {key: [node for node in nodes if node != rospy.get_name()]
                      for key, nodes in master.getSystemState()[0]}
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        return f'{topic}: the ROS master does not answer.'
    return text_about(topic, data_type, name, types, publishers)


def text_about(topic: str, data_type: str, name: str, types: Mapping[str, str],
               publishers: Mapping[str, Sequence[str]]) -> str:
    """Return the text of waiting_text; ``types``: {topic: type}, ``publishers``: {topic: other nodes}."""
    own = publishers.get(topic)
    if not own:
        text = f'{topic}: no node publishes it.'
    elif types.get(topic) not in (data_type, '*'):
        text = f'{topic}: {", ".join(own)} publishes it as {types.get(topic)}, not as {data_type}.'
    else:
        text = f'{topic}: {", ".join(own)} publishes it, but no message arrives: does that node get its own input?'
    others = sorted(key for key, nodes in publishers.items() if nodes and types.get(key) == data_type and key != topic)
    if not others:
        return f'{text} There is no other topic of type {data_type}.'
    listed = ', '.join(f'{key} (by {", ".join(publishers[key])})' for key in others)
    base = others[0][:-len(COMPRESSED)] if others[0].endswith(COMPRESSED) else others[0]  # image_transport remaps this
    return f'{text} Topics of type {data_type}: {listed}; remap with {name}:={base}'
