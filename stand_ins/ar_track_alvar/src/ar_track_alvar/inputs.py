"""What the tracker waits for when nothing comes, and what there is instead: texts for its warnings."""
import xmlrpc.client

import rosgraph
import rospy

COMPRESSED = '/compressed'  # what image_transport puts behind a picture's topic


def waiting_text(subscriber, name):
    """Return a text about a rospy.Subscriber that gets nothing; ``name``: what its topic is called unremapped."""
    topic, data_type = subscriber.resolved_name, subscriber.type
    try:
        master = rosgraph.Master(rospy.get_name())
        types = dict(master.getTopicTypes())
        publishers = dict(master.getSystemState()[0])
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        return f'{topic}: the ROS master does not answer.'
    return text_about(topic, data_type, name, types, without(rospy.get_name(), publishers))


def without(node, publishers):
    """Return {topic: nodes that publish it} without a node, and without the topics that nobody else publishes."""
    others = {topic: [name for name in nodes if name != node] for topic, nodes in publishers.items()}
    return {topic: nodes for topic, nodes in others.items() if nodes}


def text_about(topic, data_type, name, types, publishers):
    """Return the same from {topic: type} and {topic: nodes that publish it}."""
    nodes = ', '.join(publishers.get(topic, ()))
    if not nodes:
        said = f'{topic}: nobody publishes it.'
    elif types.get(topic) not in (data_type, '*'):
        said = f'{topic}: {nodes} publishes it as {types.get(topic)}, not as {data_type}.'
    else:
        said = f'{topic}: {nodes} publishes it, but nothing comes: does the camera run?'
    others = sorted(key for key in publishers if types.get(key) == data_type and key != topic)
    if not others:
        return f'{said} There is no topic of type {data_type} at all.'
    listed = ', '.join(f'{key} (by {", ".join(publishers[key])})' for key in others)
    base = others[0][:-len(COMPRESSED)] if others[0].endswith(COMPRESSED) else others[0]  # what image_transport remaps
    return f'{said} Topics of type {data_type}: {listed}; remap with {name}:={base}'
