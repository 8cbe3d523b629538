"""Start a program of the course that lies in another package, with more dependencies than this one."""
import os
import pathlib
import subprocess
import sys

CHECKOUT = pathlib.Path(__file__).resolve().parents[2]  # where this package is not installed


def run(package: str, program: str) -> None:
    """Become a program of a package, with the arguments of this one; exit with what to type if it is not there."""
    if subprocess.run(['rospack', 'find', package], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode:
        link = CHECKOUT / 'run' if (CHECKOUT / 'run').is_file() else 'THE_FOLDER_OF_turtle_robotont/run'
        sys.exit(f'{os.path.basename(sys.argv[0])}: the package {package} is not in this workspace. It comes with '
                 f'turtle_robotont. Type: {link} link ~/catkin_ws && cd ~/catkin_ws && catkin_make')
    os.execvp('rosrun', ['rosrun', package, program, *sys.argv[1:]])
