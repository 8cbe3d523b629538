#!/usr/bin/env python3
"""Nodes that run, and the pages that describe their topics and services: both name the same, with the same types."""
import re
import unittest

import rosservice
from nodes_tools import Nodes, OwnMaster, all_kinds

from rostest_support import node_pages
from rostest_support.common import run

KINDS = 'publishes', 'subscribes', 'serves'
OF_LIBRARIES = {('/rosout', 'publishes'), ('/tf', 'subscribes'), ('/tf_static', 'subscribes'), ('/clock', 'subscribes'),
                *((f'~{name}', 'serves') for name in ('get_loggers', 'set_logger_level', 'set_parameters')),
                ('~parameter_descriptions', 'publishes'), ('~parameter_updates', 'publishes')}
NOT_BY_DEFAULT = {('/clock', 'publishes', 'rosgraph_msgs/Clock'),  # with a parameter that would give all nodes its time
                  ('~moving_panels', 'publishes', 'geometry_msgs/PoseArray')}  # in a world with a panel that moves


def kinds_of_pages():
    """Return the kinds to start, with arguments that make them offer all that they can."""
    return [kind._replace(arguments=(*kind.arguments, '_model:=robotont_gazebo_lidar')) if kind.key == 'robotont'
            else kind for kind in all_kinds()]


def written(name, node, arguments):
    """Return a resolved name of a node as its page has it: without remaps, turtles of its own, and slashes."""
    for argument in arguments:
        page_name, _, other = argument.partition(':=')
        other = f'/{other.strip("/")}'
        if not page_name.startswith('_') and f'{name}/'.startswith(f'{other}/'):
            name = f'/{page_name.lstrip("/")}{name[len(other):]}'
    name = re.sub('^/turtle[0-9]+/', '/turtle1/', name)
    return name.replace(f'{node}/', '~', 1) if name.startswith(f'{node}/') else name


class PagesTest(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        """Start a node of every kind."""
        self.master = OwnMaster()
        self.master.start()
        self.addCleanup(lambda: self.master.process.stop())
        self.nodes = Nodes(self, self.master)
        kinds = kinds_of_pages()
        simulators = [kind for kind in kinds if not kind.needs]
        self.nodes.start(*simulators)
        self.nodes.spawn_turtles()
        self.nodes.start(*(kind for kind in kinds if kind.needs))

    def found(self, kind):
        """Return {(name, kind, type)} of what a node has registered."""
        types = dict(self.master.call('getTopicTypes'))

        def type_of_service(name):
            return rosservice.get_service_headers(name, self.master.call('lookupService', name))['type']
        return {(written(name, kind.node, kind.arguments), word,
                 type_of_service(name) if word == 'serves' else types[name])
                for word, names in zip(KINDS, self.master.registered(kind.node)) for name in names}

    def test_nodes_pages(self):
        scripts = {}
        for kind in self.nodes.running:
            scripts.setdefault((kind.package, kind.executable), set()).update(self.found(kind))
        wrong = []
        for (package, executable), found in scripts.items():
            folder = node_pages.REPOSITORY / 'scripts' if package == 'turtle_robotont' else \
                node_pages.REPOSITORY / 'stand_ins' / package / 'scripts'
            wrong += [f'{executable}: {text}' for text in differences(found, folder / executable)]
        self.assertEqual([], wrong, '\n'.join(wrong))


def differences(found, script):
    """Return what the page of a script says wrong; a section without such a table leaves the names to others."""
    page = node_pages.page_of(script)
    found = {entry for entry in found if entry[:2] not in OF_LIBRARIES} - NOT_BY_DEFAULT
    said = node_pages.names(node_pages.sections(page)[script.name])
    if not said:
        return [f'{name} is not mentioned' for name, _, _ in sorted(found) if f'`{name.lstrip("/")}`' not in page]
    said = {(name if name.startswith(('~', '/')) else f'/{name}', kind, data_type) for name, kind, data_type in said
            if kind != 'calls'} - NOT_BY_DEFAULT
    return ([f'{" ".join(entry)} is missing on the page' for entry in sorted(found - said)]
            + [f'{" ".join(entry)} is not in the node' for entry in sorted(said - found)])


if __name__ == '__main__':
    run(PagesTest)
