"""./run grade --live: a page for the teacher of a lab class, on which the gradings of the students appear. Without ROS.

Only who asks for it takes part: a student's ./run grade reports if the address that this program prints is given to it
(report). That address holds a code, with which one can report, but not read; the teacher's page has another.
What comes is what a stranger says: it is small, limited in number and rate, and shown as text. Nothing is stored.
"""
import argparse
import asyncio
import collections
import getpass
import hmac
import json
import logging
import secrets
import socket
import sys
import time
import urllib.error
import urllib.request
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional, Tuple

import psutil
import tornado.httpserver
import tornado.netutil
import tornado.web

from course_grader.formats import exit_codes, harmless, templates
from course_grader.formats.terminal import say
from course_grader.rules import scoring
from course_grader.rules.scoring import Verdict
from plain_support import processes

VARIABLE = 'TURTLE_ROBOTONT_REPORT'  # the address to report to, if --report does not give it
REPORT_TIMEOUT = 3.0  # [s]
PORT = 8130
MAX_BODY, MAX_HEADER = 2048, 8192  # [bytes] of a report, of its headers
LENGTHS = {'student': 60, 'exercise': 60, 'reason': 200}  # characters that are kept
MAX_STUDENTS, MAX_EXERCISES, MAX_ADDRESSES = 400, 60, 800
MAX_REPORTS, WINDOW = 30, 60.0  # reports of an address in so many seconds
IDLE = 10.0  # [s] until a connection without a whole request is closed
REFRESH = 5  # [s] between two views of the page
SIGNS = '23456789abcdefghjkmnpqrstuvwxyz'  # of a code that is read from a board: without look-alikes
CODE = 10  # signs: 49 bits


class Refused(Exception):
    """A report is not taken: its status of HTTP and the reason."""


class Last(NamedTuple):
    """What is known of a student's gradings for an exercise: the last one, and how many there were."""

    outcome: str
    score: float
    reason: str
    gradings: int
    at: float


class Board:
    """The reports of a class; ``clock()`` returns the time [s]."""

    def __init__(self, clock: Callable[[], float] = time.time) -> None:
        self._clock = clock
        self._cells: Dict[Tuple[str, str], Last] = {}
        self._times: Dict[str, Deque[float]] = collections.defaultdict(collections.deque)
        self.refused = 0

    def take(self, body: bytes, address: str) -> None:
        """Take a report of an address; raise Refused."""
        try:
            self._limit(address)
            key, last = self._parsed(body)
            students, exercises = ({other[part] for other in (*self._cells, key)} for part in (0, 1))
            if len(students) > MAX_STUDENTS or len(exercises) > MAX_EXERCISES:
                raise Refused(507, f'there are reports of {MAX_STUDENTS} students or {MAX_EXERCISES} exercises already')
        except Refused:
            self.refused += 1
            raise
        count = self._cells[key].gradings if key in self._cells else 0
        self._cells[key] = last._replace(gradings=count + 1)

    def _limit(self, address: str) -> None:
        if len(self._times) > MAX_ADDRESSES:
            raise Refused(429, 'reports come from too many addresses')
        now, times = self._clock(), self._times[address]
        while times and times[0] <= now - WINDOW:
            times.popleft()
        if len(times) >= MAX_REPORTS:
            raise Refused(429, f'there were {MAX_REPORTS} reports of {address} in {WINDOW:g} s; wait')
        times.append(now)

    def _parsed(self, body: bytes) -> Tuple[Tuple[str, str], Last]:
        try:
            content = json.loads(body)
            texts = {name: ' '.join(harmless.plain(content[name]).split())[:most] for name, most in LENGTHS.items()}
            outcome, score = content['outcome'], float(content['score'])
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            raise Refused(400, 'a report is JSON with student, exercise, outcome, score and reason') from None
        if outcome not in (*scoring.DECIDED, scoring.UNDECIDED) or not 0.0 <= score <= 100.0:
            raise Refused(400, 'the outcome or the score of a report is impossible')
        if not texts['student'] or not texts['exercise']:
            raise Refused(400, 'a report needs the names of a student and an exercise')
        return (texts['student'], texts['exercise']), Last(outcome, score, texts['reason'], 0, self._clock())

    def page(self) -> str:
        """Return the page: a row for each student, a column for each exercise."""
        students, exercises = (sorted({key[part] for key in self._cells}) for part in (0, 1))
        now = self._clock()
        rows: List[Dict[str, Any]] = []
        for student in students:
            own = [self._cells.get((student, exercise)) for exercise in exercises]
            rows.append({'student': student, 'ago': _ago(now - max(one.at for one in own if one)),
                         'cells': [_cell(one) for one in own]})
        passed = [sum(one.outcome == scoring.PASSED for (_, name), one in self._cells.items() if name == exercise)
                  for exercise in exercises]
        return templates.rendered('live.html', title='Live view', style=templates.verbatim('class_page.css'), script='',
                                  script_digest='', written=time.strftime('%H:%M:%S', time.localtime(now)), rows=rows,
                                  exercises=list(zip(exercises, passed)), refused=self.refused, refresh=REFRESH)


def _cell(one: Any) -> Dict[str, str]:
    if one is None:
        return {'verdict': 'missing', 'text': '', 'reason': ''}
    text = one.outcome if one.outcome == scoring.UNDECIDED else f'{one.score:g}'
    text += f' ({one.gradings}.)' if one.gradings > 1 else ''
    return {'verdict': one.outcome, 'text': text, 'reason': one.reason}


def _ago(seconds: float) -> str:
    return 'now' if seconds < 60.0 else f'{int(seconds // 60)} min ago'


class _Handler(tornado.web.RequestHandler):
    """Answers to who knows the secret in the path, and to nobody else."""

    def initialize(self, board: Board, secret: str) -> None:
        self.board, self.secret = board, secret

    def set_default_headers(self) -> None:
        self.clear_header('Server')
        for name, value in (('Cache-Control', 'no-store'), ('Referrer-Policy', 'no-referrer'),
                            ('X-Content-Type-Options', 'nosniff'), ('X-Frame-Options', 'DENY')):
            self.set_header(name, value)

    def check(self, given: str) -> None:
        if not hmac.compare_digest(given.encode(), self.secret.encode()):
            raise tornado.web.HTTPError(404)

    def write_error(self, status_code: int, **_: Any) -> None:
        self.set_header('Content-Type', 'text/plain; charset=utf-8')
        self.finish(f'{status_code} {self._reason}\n')


class _Page(_Handler):
    def get(self, given: str) -> None:
        self.check(given)
        self.finish(self.board.page())


class _Reports(_Handler):
    def post(self, given: str) -> None:
        self.check(given)
        try:
            self.board.take(self.request.body, self.request.remote_ip or '')
        except Refused as error:
            self.set_header('Content-Type', 'text/plain; charset=utf-8')
            self.set_status(error.args[0])
            self.finish(error.args[1] + '\n')
            return
        self.set_status(204)
        self.finish()


def server(board: Board, code: str, token: str) -> tornado.httpserver.HTTPServer:
    """Return the server of a board: reports at /CODE, the page at /view/TOKEN."""
    pages = tornado.web.Application([(r'/view/([\w-]{1,64})', _Page, {'board': board, 'secret': token}),
                                     (r'/([a-z0-9]{1,64})', _Reports, {'board': board, 'secret': code})],
                                    log_function=lambda handler: None)
    return tornado.httpserver.HTTPServer(pages, max_body_size=MAX_BODY, max_header_size=MAX_HEADER, body_timeout=IDLE,
                                         idle_connection_timeout=IDLE)


def addresses() -> List[str]:
    """Return the IPv4 addresses of this machine in its networks."""
    return [one.address for entries in psutil.net_if_addrs().values() for one in entries
            if one.family == socket.AF_INET and not one.address.startswith('127.')]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--port', type=int, default=PORT, help='default: %(default)s; 0: a free one')
    parser.add_argument('--address', default='0.0.0.0', help='the address to listen at (default: %(default)s, all '
                        'networks of this machine)')


def run(options: argparse.Namespace) -> int:
    """Show the page until Ctrl-C; return the exit code."""
    processes.make_interruptible()
    try:
        asyncio.run(_serve(options))
    except KeyboardInterrupt:
        return exit_codes.OF_OUTCOME[scoring.PASSED]
    except (OSError, OverflowError) as error:
        say(f'./run grade --live: port {options.port} of {options.address} cannot be used: '
            f'{getattr(error, "strerror", None) or error}; choose another one with --port', sys.stderr)
        return exit_codes.USAGE
    return exit_codes.OF_OUTCOME[scoring.PASSED]


async def _serve(options: argparse.Namespace) -> None:
    logging.getLogger('tornado.general').setLevel(logging.CRITICAL)  # strangers would fill the terminal
    code, token = ''.join(secrets.choice(SIGNS) for _ in range(CODE)), secrets.token_urlsafe(16)
    sockets = tornado.netutil.bind_sockets(options.port, options.address, socket.AF_INET)
    server(Board(), code, token).add_sockets(sockets)
    port = sockets[0].getsockname()[1]
    own = [options.address] if options.address != '0.0.0.0' else addresses() or ['127.0.0.1']
    here = '127.0.0.1' if options.address == '0.0.0.0' else options.address
    say('\n'.join([
        f'The page, for you alone: http://{here}:{port}/view/{token}',
        'Students who want to be seen type this before they grade, with one of these addresses:',
        *(f'  export TURTLE_ROBOTONT_REPORT=http://{address}:{port}/{code}' for address in own),
        'Ctrl-C ends it; nothing is stored.']))
    await asyncio.Event().wait()


class ReportError(ValueError):
    """A report cannot be sent; the text says why, and what to do."""


def check_address(address: Optional[str]) -> None:
    """Raise ReportError unless an address can be reported to; '' or None: nobody asks for a report."""
    if address and not address.startswith(('http://', 'https://')):
        raise ReportError(f'the address to report to is {address!r}; copy it whole from your teacher\'s ./run grade '
                          '--live, such as http://192.168.1.5:8130/abcdefghij')


def report(address: str, student: Optional[str], exercise: str, verdict: Verdict) -> None:
    """Report a grading of this user, or of ``student``; raise ReportError. It takes at most about REPORT_TIMEOUT."""
    content = {'student': student or user(), 'exercise': exercise, 'outcome': verdict.outcome, 'score': verdict.score,
               'reason': verdict.public().main_reason()[:LENGTHS['reason']]}
    try:
        request = urllib.request.Request(address, json.dumps(content).encode(), {'Content-Type': 'application/json'})
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # it is in the same room
        opener.open(request, timeout=REPORT_TIMEOUT).close()
    except urllib.error.HTTPError as error:
        answer = error.read(LENGTHS['reason']).decode(errors='replace').strip()
        raise ReportError('its code is wrong: copy the address again' if error.code == 404 else answer or str(error)
                          ) from None
    except (OSError, ValueError) as error:
        raise ReportError(str(getattr(error, 'reason', error))) from None


def user() -> str:
    """Return the name of the user who runs this."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return 'somebody'
