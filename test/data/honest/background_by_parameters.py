#!/usr/bin/env python3
"""Subprocesses: tools of ROS by name, a pipe, a file in the temporary folder, and a pool of processes."""
import multiprocessing
import subprocess
import tempfile

import yaml


def call(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def component(of):
    return of, 0 if of == 'b' else 255


if __name__ == '__main__':
    with multiprocessing.Pool(2) as pool:
        colour = {f'background_{of}': value for of, value in pool.map(component, 'rgb')}
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
        yaml.safe_dump(colour, file)
        file.flush()
        call('rosparam', 'load', file.name, '/turtlesim')
    call('rosservice', 'call', '/clear')
    print('done', call('bash', '-c', 'rosparam get /turtlesim | grep background').replace('\n', ' '))
