"""Start rviz with the configuration for a Robotont, or name the missing part. Uses only rospkg of ROS."""
import argparse
import os
import shutil
import sys
from typing import Callable, List, Mapping, Optional, Sequence

FIXED_FRAME = 'odom'


class CannotStart(Exception):
    """rviz cannot be started here; the text says what to do."""


def command(prefix: str, folder: str, others: Sequence[str] = (), find: Callable[[str], Optional[str]] = shutil.which,
            environment: Mapping[str, str] = os.environ, fixed_frame: Optional[str] = None) -> List[str]:
    """Return the command line of rviz; raise CannotStart if it is not installed or there is no display.

    ``prefix`` is that of the frame names, ``folder`` that of robotont_description; ``others`` are further arguments.
    rviz shows everything in ``fixed_frame``; default: the odometry's.
    """
    program = find('rviz')
    if program is None:
        raise CannotStart('rviz is not installed. To install it, type: ./run build --rviz (in a workspace of your own: '
                          'sudo apt-get install --no-install-recommends rviz)')
    if not environment.get('DISPLAY') and not environment.get('WAYLAND_DISPLAY'):
        raise CannotStart('rviz needs a display, and DISPLAY is not set. Start it in a terminal on the desktop, or '
                          'leave out rviz:=true')
    config = os.path.join(folder, 'config', 'robotont_description.rviz')
    return [program, '-d', config, '-f', fixed_frame or f'{prefix}{FIXED_FRAME}', *others]


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Replace this process by rviz."""
    parser = argparse.ArgumentParser(description='Start rviz with the configuration for a Robotont.')
    parser.add_argument('--prefix', default='', help='prefix of the names of frames, e.g. robot1/')
    parser.add_argument('-f', '--fixed-frame', help='frame in which everything is shown; default: odom')
    options, others = parser.parse_known_args(arguments)
    import rospkg
    try:
        words = command(options.prefix, rospkg.RosPack().get_path('robotont_description'), others,
                        fixed_frame=options.fixed_frame)
    except CannotStart as error:
        sys.exit(f'robotont_rviz: {error}.')
    os.execv(words[0], words)
