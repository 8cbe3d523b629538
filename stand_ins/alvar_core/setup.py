from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

PACKAGES = ['alvar_core', 'alvar_core.detection', 'alvar_core.printing']

setup(**generate_distutils_setup(packages=PACKAGES, package_dir={'': 'src'}))
