"""What goes wrong on a machine with ROS 1, found before or while it does; ``cli`` is ``./run doctor``.

Nodes and the grader use the public modules: ``findings`` has the text and the cure of each problem; ``addresses``,
``devices``, ``names``, ``programs`` and ``registrations`` find some of them. It needs nothing but Python, because it
has to work where nothing else is installed, and it changes nothing.
"""
