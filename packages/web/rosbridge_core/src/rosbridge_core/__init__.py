"""The rosbridge protocol, version 2: operations, encodings, queues and access rules. Without ROS."""
