"""Why rosrun cannot start a Python program: its mode, its first line, its line ends. Without ROS."""
import os
import re
import shutil
from typing import Iterator, Mapping, Optional

from plain_support.doctor import findings
from plain_support.doctor.findings import Finding

BYTE_ORDER_MARK = b'\xef\xbb\xbf'  # some editors of Windows write it at the start of a file
PYTHON2 = re.compile(r'python2(\.\d+)?$')


def faults(path: str, content: bytes, environment: Mapping[str, str] = os.environ) -> Iterator[Finding]:
    """Yield why rosrun cannot start a Python program; ``content`` is the start of the file, or all of it."""
    marked = content.startswith(BYTE_ORDER_MARK)
    first = content[len(BYTE_ORDER_MARK) * marked:].split(b'\n', 1)[0].decode(errors='replace').rstrip('\r')
    if marked:
        yield findings.byte_order_mark(path)
    if b'\r\n' in content:
        yield findings.windows_line_ends(path)
    if not first.startswith('#!'):
        yield findings.no_shebang(path)
    else:
        why = _unusable(first[2:].strip(), environment)
        if why:
            yield findings.wrong_shebang(path, first, why)
    if not os.access(path, os.X_OK):
        yield findings.not_executable(path)


def _unusable(interpreter: str, environment: Mapping[str, str]) -> Optional[str]:
    """Return why the interpreter of a first line cannot run a Python 3 program; None if it can."""
    command, _, argument = interpreter.partition(' ')
    name = re.sub(r'^-S\s+(\S+).*', r'\1', argument.strip()) if os.path.basename(command) == 'env' else command
    found = shutil.which(name, path=environment.get('PATH', os.defpath)) if name else None
    if found is None or not os.access(command, os.X_OK):
        return f'there is no {name if os.access(command, os.X_OK) else command} here'
    if PYTHON2.search(os.path.realpath(found)):
        return f'{name} is Python 2'
    return None if 'python' in os.path.basename(name) else f'{name} is not Python'
