"""Choose a turtle's design without drawing it; sprites.py has the designs in the same order."""
import zlib

FILES = ('sea-turtle', 'robot-turtle', 'diamondback', 'noetic', 'electric', 'fuerte', 'groovy', 'hydro', 'indigo',
         'box-turtle')  # images/NAME.png of each design: names that turtlesim has
NAME_SHIFT = 15  # selects bits of the CRC-32 in which turtle1 to turtle7 all differ


def design_of(name: str) -> int:
    """Return the index of a turtle's design, which follows from its name."""
    return (zlib.crc32(name.encode()) >> NAME_SHIFT) % len(FILES)
