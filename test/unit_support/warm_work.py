"""What the processes of test_warm_start.py do: in a module that a Python process started anew can import."""
import os
import signal
import time


def work(module, argument):
    """Do what the argument says; the module is json."""
    if argument == 'crash':
        raise RuntimeError('as asked')
    if argument == 'kill':
        os.kill(os.getpid(), signal.SIGKILL)
    if argument == 'sleep':
        time.sleep(1000.0)
    return module.dumps([argument, os.getpid(), os.getsid(0)])
