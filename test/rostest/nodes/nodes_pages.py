"""Nodes that run, and the pages that describe their topics and services: do both name the same, with the same types?"""
import re

import rosservice

from plain_support import packages
from rostest_support import node_pages

KINDS = 'publishes', 'subscribes', 'serves'
OF_LIBRARIES = {('/rosout', 'publishes'), ('/tf', 'subscribes'), ('/tf_static', 'subscribes'), ('/clock', 'subscribes'),
                *((f'~{name}', 'serves')
                  for name in ('get_loggers', 'set_logger_level', 'set_parameters', 'tf2_frames')),
                ('~parameter_descriptions', 'publishes'), ('~parameter_updates', 'publishes')}
NOT_BY_DEFAULT = {('/clock', 'publishes', 'rosgraph_msgs/Clock'),  # with a parameter that would give all nodes its time
                  ('~moving_panels', 'publishes', 'geometry_msgs/PoseArray')}  # in a world with a panel that moves


def written(name, node, arguments):
    """Return a resolved name of a node as its page has it: without remaps, turtles of its own, and slashes."""
    for argument in arguments:
        page_name, _, other = argument.partition(':=')
        other = f'/{other.strip("/")}'
        if not page_name.startswith('_') and f'{name}/'.startswith(f'{other}/'):
            name = f'/{page_name.lstrip("/")}{name[len(other):]}'
    name = of_any_turtle(name)
    return name.replace(f'{node}/', '~', 1) if name.startswith(f'{node}/') else name


def of_any_turtle(name):
    """Return a name with turtle1 for whatever turtle it has."""
    return re.sub('^/turtle[0-9]+/', '/turtle1/', name)


def names_and_types(master, kind):
    """Return {(name, kind, type)} of the registrations of a running node, with the names on its page."""
    types = dict(master.call('getTopicTypes'))

    def type_of_service(name):
        return rosservice.get_service_headers(name, master.call('lookupService', name))['type']
    return {(written(name, kind.node, kind.arguments), word,
             type_of_service(name) if word == 'serves' else types[name])
            for word, names in zip(KINDS, master.registered(kind.node)) for name in names}


def wrong_pages(found):
    """Return what pages say wrong; ``found``: {NodeKind: names_and_types of it}."""
    scripts, wrong = {}, []
    for kind, names in found.items():
        scripts.setdefault((kind.package, kind.executable), set()).update(names)
    for (package, executable), names in scripts.items():
        script = packages.folder(package).resolve() / 'scripts' / executable
        wrong += [f'{executable}: {text}' for text in differences(names, script)]
    return wrong


def differences(found, script):
    """Return the errors on the page of a script; a section without such a table refers to another one."""
    page = node_pages.page_of(script)
    found = {entry for entry in found if entry[:2] not in OF_LIBRARIES} - NOT_BY_DEFAULT
    described = node_pages.names(node_pages.sections(page)[script.name])
    if not described:
        return [f'{name} is not mentioned' for name, _, _ in sorted(found) if f'`{name.lstrip("/")}`' not in page]
    described = {(of_any_turtle(name if name.startswith(('~', '/')) else f'/{name}'), kind, data_type)
                 for name, kind, data_type in described
                 if kind != 'calls' and (name, kind) not in OF_LIBRARIES} - NOT_BY_DEFAULT
    return ([f'{" ".join(entry)} is missing on the page' for entry in sorted(found - described)]
            + [f'{" ".join(entry)} is not in the node' for entry in sorted(described - found)])

