"""Run the tests that failed in the last ./run test once more, alone; they are named. For .ci/run, in a ./run shell."""
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

MOST = 5  # tests; if more fail, load is not the cause


def failed(results):
    """Return the names of the failed tests in a folder of results; exit if a run of pytest did not come to its end.

    Of a parametrized test, all cases: the results do not hold the names of cases as they are typed.
    """
    names = set()
    for output in sorted(results.glob('*.txt')):
        if not output.with_suffix('.xml').exists():
            sys.exit(f'{output} has no results')
        for case in ElementTree.parse(output.with_suffix('.xml')).iter('testcase'):
            if case.find('failure') is not None or case.find('error') is not None:
                path = case.get('classname')
                path, ending = (path[:-len('.test')], '.test') if path.endswith('.test') else (path, '.py')
                names.add(f'{path.replace(".", "/")}{ending}::{case.get("name").partition("[")[0]}')
    return sorted(names)


def main():
    names = failed(pathlib.Path(os.environ['VIRTUAL_ENV']).parent / 'test_results' / 'latest')
    if not 0 < len(names) <= MOST:
        sys.exit(f'{len(names)} tests failed; at most {MOST} are run again.')
    print('AGAIN, alone, as they failed beside others:', *names, sep='\n  ', flush=True)
    sys.exit(subprocess.run([sys.executable, '-m', 'pytest', '-q', '--tb=short', *names], check=False).returncode)


if __name__ == '__main__':
    main()
