"""Turn a URDF into an SDF <model>, as Gazebo does before it reads a robot. No ROS.

All joints are at zero. The contents of <gazebo> tags are moved: sensors into their link, plugins into the model.
"""
from typing import Dict, List, Optional
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from plain_support import InvalidInput, shown
from plain_support.rotations import matrix_from_rpy, rpy_from_matrix

ATTRIBUTES = {'box': ('size',), 'cylinder': ('radius', 'length'), 'sphere': ('radius',), 'mesh': ('scale',)}


def to_sdf(robot: Element) -> Element:
    """Return the <model> of a <robot>; raise InvalidInput unless its links and joints form a tree."""
    if robot.tag != 'robot':
        raise InvalidInput(f'not a URDF: the text begins with <{robot.tag:.80}>; it must be <robot>')
    model = Element('model', name=robot.get('name') or 'robot')
    poses = _link_poses(robot)
    colours = _colours(robot)
    links: Dict[str, Element] = {}
    for link in robot.findall('link'):
        name = link.get('name') or ''
        links[name] = made = SubElement(model, 'link', name=name)
        _add_pose(made, poses[name])
        for tag in ('collision', 'visual'):
            for number, part in enumerate(link.findall(tag)):
                _add_part(made, part, f'{name}_{tag}_{number}', colours)
    for joint in robot.findall('joint'):
        _add_joint(model, joint)
    for extension in robot.findall('gazebo'):
        _extend(model, links, extension)
    return model


def _link_poses(robot: Element) -> Dict[str, np.ndarray]:
    """Return {link: its pose (4, 4) in the frame of the root link}."""
    names = [link.get('name') or '' for link in robot.findall('link')]
    parents: Dict[str, Element] = {}
    for joint in robot.findall('joint'):
        child, parent = (_linked(joint, tag) for tag in ('child', 'parent'))
        for name in (child, parent):
            if name not in names:
                raise InvalidInput(f'the joint {shown(joint.get("name"))} names the link {shown(name)}, which is '
                                   'missing')
        parents[child] = joint
    poses: Dict[str, np.ndarray] = {}
    for name in names:
        chain: List[str] = []
        above = name
        while above in parents and above not in poses:
            if above in chain:
                raise InvalidInput(f'the link {shown(above)} is its own parent')
            chain.append(above)
            above = _linked(parents[above], 'parent')
        pose = poses.setdefault(above, np.eye(4))
        for child in reversed(chain):
            pose = poses[child] = pose @ _origin(parents[child])
    return poses


def _linked(joint: Element, tag: str) -> str:
    element = joint.find(tag)
    return (element.get('link') or '') if element is not None else ''


def _origin(element: Element) -> np.ndarray:
    origin = element.find('origin')
    matrix = np.eye(4)
    if origin is not None:
        x, y, z = _three(origin.get('xyz'))
        roll, pitch, yaw = _three(origin.get('rpy'))
        matrix[:3, :3], matrix[:3, 3] = matrix_from_rpy(roll, pitch, yaw), (x, y, z)
    return matrix


def _three(text: Optional[str]) -> List[float]:
    try:
        numbers = [float(word) for word in (text or '0 0 0').split()]
    except ValueError:
        numbers = []
    if len(numbers) != 3 or not np.isfinite(numbers).all():
        raise InvalidInput(f'<origin> has {shown(text)}; it must be three finite numbers')
    return numbers


def _add_pose(element: Element, pose: np.ndarray) -> None:
    SubElement(element, 'pose').text = ' '.join(f'{number:.9g}' for number in (
        *pose[:3, 3], *rpy_from_matrix(pose[:3, :3])))


def _add_part(link: Element, part: Element, name: str, colours: Dict[str, str]) -> None:
    """Add a <collision> or <visual> with its geometry and colour."""
    made = SubElement(link, part.tag, name=name)
    _add_pose(made, _origin(part))
    geometry = SubElement(made, 'geometry')
    for kind in part.findall('geometry/*'):
        shape = SubElement(geometry, kind.tag)
        for attribute in ATTRIBUTES.get(kind.tag, ()):
            if kind.get(attribute):
                SubElement(shape, attribute).text = kind.get(attribute)
        if kind.get('filename'):
            SubElement(shape, 'uri').text = kind.get('filename')
    material = part.find('material')
    if material is not None:
        colour = material.find('color')
        rgba = colour.get('rgba') if colour is not None else colours.get(material.get('name') or '')
        if rgba:
            SubElement(SubElement(made, 'material'), 'diffuse').text = rgba


def _colours(robot: Element) -> Dict[str, str]:
    """Return {material: its rgba} of the materials defined beside the links."""
    found = {material.get('name') or '': material.find('color') for material in robot.iter('material')}
    return {name: colour.get('rgba') or '' for name, colour in found.items() if colour is not None}


def _add_joint(model: Element, joint: Element) -> None:
    made = SubElement(model, 'joint', name=joint.get('name') or '', type=joint.get('type') or '')
    for tag in ('parent', 'child'):
        SubElement(made, tag).text = _linked(joint, tag)


def _extend(model: Element, links: Dict[str, Element], extension: Element) -> None:
    """Add the content of a tag <gazebo> to the model, or to the link that it names."""
    reference = extension.get('reference')
    if not reference:
        model.extend(list(extension))
        return
    link = links.get(reference)
    if link is None:
        return  # settings of a joint, such as its friction
    link.extend(extension.findall('sensor'))
    link.extend(extension.findall('plugin'))
    name = (extension.findtext('material') or '').strip()
    if name:
        for visual in link.findall('visual'):
            for material in visual.findall('material'):
                visual.remove(material)
            SubElement(SubElement(SubElement(visual, 'material'), 'script'), 'name').text = name
