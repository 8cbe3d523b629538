"""What to say when nothing comes on a topic: who publishes it, and where such messages come instead."""
import xmlrpc.client

import rosgraph
import rospy


def waiting_text(subscriber, name):
    """Return a text about a rospy.Subscriber that gets nothing; ``name``: what its topic is called unremapped."""
    topic, data_type = subscriber.resolved_name, subscriber.type
    try:
        master = rosgraph.Master(rospy.get_name())
        types = dict(master.getTopicTypes())
        publishers = {key: nodes for key, nodes in master.getSystemState()[0] if nodes}
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        return f'Nothing comes on {topic}; the ROS master does not answer either.'
    return text_about(topic, data_type, name, types, publishers)


def text_about(topic, data_type, name, types, publishers):
    """Return the same from {topic: type} and {topic: nodes that publish it}."""
    own = publishers.get(topic, ())
    if not own:
        said = f'Nothing comes on {topic}: nobody publishes it.'
    elif types.get(topic) not in (data_type, '*'):
        said = f'Nothing comes on {topic}: {", ".join(own)} publishes it as {types.get(topic)}, not as {data_type}.'
    else:
        said = f'Nothing comes on {topic}, though {", ".join(own)} publishes it.'
    others = sorted(key for key in publishers if types.get(key) == data_type and key != topic)
    if not others:
        return said
    listed = ', '.join(f'{key} (by {", ".join(publishers[key])})' for key in others)
    return f'{said} There is {listed} of the type {data_type}; remap with {name}:={others[0]} .'
