from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(scripts=['scripts/rqt_console']))  # typed without rosrun, as the original
