import glob

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(scripts=sorted(glob.glob('scripts/*'))))  # typed without rosrun, as the originals
