"""What the tracker waits for when nothing comes, and what there is instead: texts for its warnings."""
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
        return f'{topic}: the ROS master does not answer.'
    return text_about(topic, data_type, name, types, publishers)


def text_about(topic, data_type, name, types, publishers):
    """Return the same from {topic: type} and {topic: nodes that publish it}."""
    own = [node for node in publishers.get(topic, ()) if node != rospy.get_name()]
    if not own:
        said = f'{topic}: nobody publishes it.'
    elif types.get(topic) not in (data_type, '*'):
        said = f'{topic}: {", ".join(own)} publishes it as {types.get(topic)}, not as {data_type}.'
    else:
        said = f'{topic}: {", ".join(own)} publishes it, but nothing comes: does the camera run?'
    others = sorted(key for key in publishers if types.get(key) == data_type and key != topic)
    if not others:
        return f'{said} There is no topic of type {data_type} at all.'
    listed = ', '.join(f'{key} (by {", ".join(publishers[key])})' for key in others)
    return f'{said} Topics of type {data_type}: {listed}; remap with {name}:={others[0]}'
