from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

PACKAGES = ['turtle_robotont', 'turtle_robotont.grading', 'turtle_robotont.grading.student_path']

setup(**generate_distutils_setup(packages=PACKAGES, package_dir={'': 'src'}))
