from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=['turtle_robotont', 'turtle_robotont.grading',
                                              'turtle_robotont.grading.student_path'], package_dir={'': 'src'}))
