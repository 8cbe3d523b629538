"""The work of the processes in test_warm_start.py, in a module that a new Python process can import."""
import os
import signal
import time

prepared = []  # in the server


def prepare(argument):
    """Note what the server prepares for."""
    prepared.append(argument)


def report(module, argument):
    """Return what the server had prepared before this process was forked; the module is this one."""
    return module.prepared


def work(module, argument):
    """Do the work that the argument names; the module is json."""
    if argument == 'crash':
        raise RuntimeError('as asked')
    if argument == 'kill':
        os.kill(os.getpid(), signal.SIGKILL)
    if argument == 'sleep':
        time.sleep(1000.0)
    return module.dumps([argument, os.getpid(), os.getsid(0)])
