"""The compiled renderer steps on no memory but its own, and does nothing that C++ leaves undefined."""
import pathlib
import subprocess

import pytest

pytestmark = pytest.mark.slow

HERE = pathlib.Path(__file__).parent
NATIVE = HERE.parents[1] / 'native'
FLAGS = ('-std=c++17', '-O1', '-g', '-fsanitize=address,undefined', '-fno-sanitize-recover=undefined',
         '-D_GLIBCXX_ASSERTIONS', '-DROBOTONT_FAST=', '-Wall', '-Wextra', '-Wno-psabi')


@pytest.mark.nightly
def test_address_and_undefined_behaviour_sanitizers_find_nothing(tmp_path):
    program = tmp_path / 'random_scenes'
    sources = [HERE / 'random_scenes.cpp', *(NATIVE / f'{name}.cpp' for name in ('visibility', 'picture', 'depth'))]
    subprocess.run(['g++', *FLAGS, f'-I{NATIVE}', *sources, '-o', program], check=True, timeout=600)
    assert subprocess.run([program], stdout=subprocess.PIPE, text=True, check=True, timeout=300).stdout == 'drawn\n'
