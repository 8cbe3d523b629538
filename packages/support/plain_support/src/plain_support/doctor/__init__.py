"""Find problems of a machine with ROS 1, before or after they show; ``cli`` is ``./run doctor``.

Nodes and the grader use the public modules: ``findings`` has the text and the remedy of each problem; ``addresses``,
``devices``, ``names``, ``programs`` and ``registrations`` find some of them. It needs only Python, because it must
work where nothing else is installed, and it changes nothing.
"""
