"""Outlines of models of Gazebo's public database, which worlds include by name without bringing them along. No ROS.

Each is a list of boxes and upright cylinders, in metres; the sizes are those of the database's collision shapes, and of
the outlines of its meshes. Legs and boards that no robot or laser meets are left out.
"""
from typing import Dict, Optional, Tuple
from xml.etree.ElementTree import Element, SubElement

BOX, CYLINDER = 'box', 'cylinder'
Part = Tuple[str, Tuple[float, float, float], Tuple[float, ...]]  # kind, middle (x, y, z), size or (radius, length)

MODELS: Dict[str, Tuple[Part, ...]] = {
    'beer': ((CYLINDER, (0.0, 0.0, 0.115), (0.055, 0.23)),),
    'bookshelf': ((BOX, (0.0, -0.195, 0.6), (0.92, 0.4, 1.2)),),
    'bowl': ((CYLINDER, (0.0, 0.0, 0.0175), (0.098, 0.035)),),
    'brick_box_3x1x3': ((BOX, (0.0, 0.0, 1.5), (3.0, 1.0, 3.0)),),
    'cabinet': ((BOX, (0.0, 0.0, 0.51), (0.49, 0.49, 1.02)),),
    'cafe_table': ((BOX, (0.0, 0.0, 0.755), (0.913, 0.913, 0.04)), (BOX, (0.0, 0.0, 0.37), (0.042, 0.042, 0.74)),
                   (BOX, (0.0, 0.0, 0.02), (0.56, 0.56, 0.04))),
    'cardboard_box': ((BOX, (0.0, 0.0, 0.15), (0.5, 0.4, 0.3)),),
    'cinder_block': ((BOX, (0.0, 0.0, 0.1016), (0.435, 0.203, 0.203)),),
    'coke_can': ((CYLINDER, (0.0, 0.0, 0.06), (0.033, 0.12)),),
    'construction_barrel': ((CYLINDER, (0.0, 0.0, 0.775), (0.51, 1.55)),),
    'construction_cone': ((CYLINDER, (0.0, 0.0, 0.545), (0.25, 1.09)),),
    'fire_hydrant': ((CYLINDER, (0.0, 0.0, 0.385), (0.212, 0.77)),),
    'grey_wall': ((BOX, (0.0, 0.0, 1.4), (7.5, 0.2, 2.8)),),
    'jersey_barrier': ((BOX, (0.0, 0.0, 0.5715), (4.065, 0.306, 1.143)), (BOX, (0.0, 0.0, 0.125), (4.065, 0.65, 0.25))),
    'table': ((BOX, (0.0, 0.0, 1.0), (1.5, 0.8, 0.03)), *[(CYLINDER, (x, y, 0.5), (0.02, 1.0))
                                                         for x in (-0.68, 0.68) for y in (-0.38, 0.38)]),
    'unit_box': ((BOX, (0.0, 0.0, 0.5), (1.0, 1.0, 1.0)),),
    'unit_cylinder': ((CYLINDER, (0.0, 0.0, 0.5), (0.5, 1.0)),),
    'wood_cube_10cm': ((BOX, (0.0, 0.0, 0.05), (0.1, 0.1, 0.1)),),
}


def model(name: str) -> Optional[Element]:
    """Return the SDF <model> of this name, None if it is not known."""
    parts = MODELS.get(name)
    if parts is None:
        return None
    element = Element('model', name=name)
    link = SubElement(element, 'link', name='link')
    for number, (kind, middle, size) in enumerate(parts):
        collision = SubElement(link, 'collision', name=f'collision_{number}')
        SubElement(collision, 'pose').text = ' '.join(map(str, (*middle, 0.0, 0.0, 0.0)))
        shape = SubElement(SubElement(collision, 'geometry'), kind)
        names = ('size',) if kind == BOX else ('radius', 'length')
        for tag, text in zip(names, (' '.join(map(str, size)),) if kind == BOX else map(str, size)):
            SubElement(shape, tag).text = text
    return element
