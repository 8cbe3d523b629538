"""What `./run bench` needs as a command: options, progress, files, and how it ends."""
import argparse
import contextlib
import os
import shutil
import sys
import tempfile

from plain_support import write_whole
from plain_support.processes import INTERRUPTED, make_interruptible
from processes import BenchError, stop_all


def positive(kind):
    """Return a function of a text for argparse that accepts finite numbers of this ``kind`` above 0."""
    def convert(text):
        value = kind(text)
        if not 0 < value < float('inf'):
            raise argparse.ArgumentTypeError(f'it is {text}; it must be above 0')
        return value
    convert.__name__ = kind.__name__
    return convert


def progress(text):
    """Print the progress on stderr; stdout is for the table."""
    print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def processes_in_folder():
    """Yield a temporary folder; end all processes afterwards, and delete it."""
    folder = tempfile.mkdtemp(prefix='turtle_robotont_bench_')
    try:
        yield folder
    finally:
        stop_all()
        shutil.rmtree(folder, ignore_errors=True)


def write_figures(path, text):
    """Write the JSON of a run; raise BenchError if that is impossible."""
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        raise BenchError(f'The figures cannot be written: {error}. Choose another file with --json FILE.') from error
    progress(f'Figures: {path}')


def exit_code(name, run):
    """Return that of ``run()``; say what ended it otherwise."""
    make_interruptible()
    try:
        return run()
    except BenchError as error:
        progress(f'{name}: {error}')
        return 1
    except KeyboardInterrupt:
        progress(f'{name}: interrupted; all its processes have ended')
        return INTERRUPTED
