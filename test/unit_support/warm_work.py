"""The work of the processes in test_warm_start.py, in a module that a new Python process can import."""
import os
import signal
import time


def work(module, argument):
    """Do the work that the argument names; the module is json."""
    if argument == 'crash':
        raise RuntimeError('as asked')
    if argument == 'kill':
        os.kill(os.getpid(), signal.SIGKILL)
    if argument == 'sleep':
        time.sleep(1000.0)
    return module.dumps([argument, os.getpid(), os.getsid(0)])
