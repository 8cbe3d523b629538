"""Settings of all tests; test/collection says what pytest collects beside test_*.py."""
import os
import signal
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parent
pytest_plugins = ['collection.plugin']

# Without a sourced workspace the modules are found here; in one they are found where it has them.
packages = (*sorted(REPOSITORY.glob('packages/**/package.xml')), REPOSITORY / 'test/rostest_support/package.xml')
folders = [str(REPOSITORY / 'src'), *(str(path.parent / 'src') for path in packages if (path.parent / 'src').is_dir())]
sys.path += folders
if 'ROS_PACKAGE_PATH' not in os.environ:  # programs that tests start find them, too
    os.environ['PYTHONPATH'] = os.pathsep.join(folders)

# What a test asks on this machine does not go through a proxy; what it starts can be interrupted also if the tests run
# in the background, where a shell has SIGINT ignored.
for variable in ('no_proxy', 'NO_PROXY'):
    os.environ[variable] = ','.join(filter(None, ('localhost,127.0.0.1', os.environ.get(variable))))
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

try:
    import hypothesis
except ImportError:
    pass  # its tests are skipped
else:
    hypothesis.settings.register_profile('nightly', derandomize=True, database=None, deadline=None)
    hypothesis.settings.register_profile('change', hypothesis.settings.get_profile('nightly'), max_examples=15)
    hypothesis.settings.load_profile('nightly')  # the plugin loads the other, if only a change is tested


@pytest.fixture(autouse=True)
def signals():
    """Restore the handlers of signals that a command sets; programs of later tests would inherit an ignored one."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        if handler is not None:
            signal.signal(number, handler)
