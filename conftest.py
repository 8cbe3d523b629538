"""Settings of all tests; test/collection says what pytest collects beside test_*.py."""
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent
pytest_plugins = ['collection.plugin']

# Without a sourced workspace the modules are found here; in one they are found where it has them.
sys.path += [str(folder) for folder in (REPOSITORY / 'src', *sorted(REPOSITORY.glob('*/*/src')))]

try:
    import hypothesis
except ImportError:
    pass  # its tests are skipped
else:
    hypothesis.settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
    hypothesis.settings.load_profile('repeatable')
