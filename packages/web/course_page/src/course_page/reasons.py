"""The end of a program's output, and the line in it that tells why the program has ended."""
import re
from typing import List

CONTROL = re.compile(r'\x1b\[[0-9;]*[A-Za-z]|\x1b\][^\x07]*\x07')  # colours and the title of the terminal
LAST_LINES = 12  # of an output
WIDEST = 200  # [characters] of each
LONGEST = 400  # [characters] of the line that tells why
# What roslaunch writes at the end, whatever the reason is
CHATTER = re.compile(
    r'\[[\w/.-]+\] (killing on exit|restarting process|escalating to)|(\.\.\. )?shutting down processing|done$|=+'
    r'|REQUIRED process|process has (died|finished)|process\[|log file: |Initiating shutdown|\.\.\. logging to|started '
    r'|auto-starting|setting /|ROS_MASTER_URI=|Press Ctrl-C|(Done c|C)hecking log|The traceback for the exception'
    r'|SUMMARY$|PARAMETERS$|NODES$| \* |  /|    ')
SERIOUS = re.compile(r'\[(ERROR|FATAL)\]|RLException|^\w*(Error|Exception)\b|\b[Ee]rror:|\bdoes not start\b|what\(\):'
                     r'|[Cc]annot ')
QUIET = re.compile(r'\[ *(INFO|DEBUG)\]')
STAMP = re.compile(r'\[ *(ERROR|FATAL|WARN|INFO|DEBUG)\] \[[\d., ]+\]:? ?|(ERROR|RLException|usage|\w+\.py): ')
DIED = re.compile(r'process has died \[pid \d+, exit code (-?\d+), cmd (\S+)')


def last_lines(output: str) -> str:
    """Return the last lines of an output, without colours."""
    return '\n'.join(line[:WIDEST] for line in _plain(output)[-LAST_LINES:])


def reason(output: str) -> str:
    """Return the line that tells why a program has ended, or ''."""
    lines = [line.rstrip() for line in _plain(output)]
    own = [line for line in lines if line and not CHATTER.match(line) and not QUIET.match(line)]
    serious = [line for line in own if SERIOUS.search(line)]
    if own:
        return STAMP.sub('', (serious or own)[-1], count=1)[:LONGEST]
    match = DIED.search('\n'.join(lines))
    if match:
        code, program = match.groups()
        return f'{program.rpartition("/")[2]} has ended with the exit code {code}'
    return ''


def _plain(output: str) -> List[str]:
    """Return the lines of an output without colours."""
    return CONTROL.sub('', output).strip().splitlines()


def died(output: str) -> bool:
    """Return whether a roslaunch tells that one of its programs has died; its own exit code does not."""
    return bool(DIED.search(CONTROL.sub('', output)))
