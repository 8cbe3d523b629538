"""Names of colours in world files: those of Gazebo's materials."""
from typing import Dict

from kinematic_core.worlds.floor_plan import Colour

COLOURS: Dict[str, Colour] = {  # (r, g, b), 0..255
    'black': (0, 0, 0), 'blue': (0, 0, 255), 'darkgrey': (45, 45, 45), 'green': (0, 255, 0), 'grey': (178, 178, 178),
    'indigo': (84, 0, 128), 'orange': (255, 130, 12), 'purple': (255, 0, 255), 'red': (255, 0, 0),
    'turquoise': (0, 255, 255), 'white': (255, 255, 255), 'whitebricks': (226, 222, 214), 'wood': (156, 102, 50),
    'yellow': (255, 255, 0),
}
