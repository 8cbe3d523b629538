"""The common basis of all nodes, on top of rospy. Public modules:

* ``nodes``: how a node starts and ends; ``parameters``: its parameters in one table, checked.
* ``topics``: publishers that never wait; ``images``: images to and from arrays; ``rotations``: headings to quaternions.
* ``threads``, ``throttle``: threads that survive errors, and log lines that do not fill the log.
* ``registration``, ``reachability``, ``topic_diagnosis``: for a node that the master forgets, that other nodes cannot
  reach, or that waits for messages.
* ``servers``: protection of the two servers of a node, for programs that call rospy.init_node themselves.
* ``master``, ``own_master``, ``ports``, ``limited_transport``: calls of a ROS master, and private ones.
* ``key_terminal``: single keys from a terminal.
* ``rospy_internals``: the only place that uses private parts of rospy.

The other modules are parts of these. No module is imported here, because not every program needs OpenCV or tf.
"""
__all__ = ['images', 'key_terminal', 'limited_transport', 'master', 'nodes', 'own_master', 'parameters', 'ports',
           'reachability', 'registration', 'rospy_internals', 'rotations', 'servers', 'threads', 'throttle',
           'topic_diagnosis', 'topics']
