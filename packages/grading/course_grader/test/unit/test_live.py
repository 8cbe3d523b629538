"""./run grade --live: who asks for it is on the page; hostile reporters change nothing, and stop nothing."""
import asyncio
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading

import pytest
import tornado.netutil

from course_grader.classes import live
from course_grader.classes.live import MAX_REPORTS, MAX_STUDENTS, Board
from course_grader.rules.scoring import Reason, Verdict

pytestmark = pytest.mark.slow

CODE, TOKEN = 'k3x9qa2bcd', 'a-secret_view'
TIMEOUT = 20.0  # [s]
PASSED = Verdict('passed', 100.0, [], [])
FAILED = Verdict('failed', 40.0, [Reason('moves', 20.0, 20.0, 'a path', '4 m'),
                                  Reason('stops', 0.0, 80.0, 'a secret', 'none', 'never')], [])
REPORT = {'student': 'anna', 'exercise': 'stop_at_x', 'outcome': 'passed', 'score': 100, 'reason': ''}


class Served:
    """A live view on a free port of loopback, in a thread of its own."""

    def __init__(self):
        self.board, self.loop, started = Board(), asyncio.new_event_loop(), threading.Event()

        async def start():
            sockets = tornado.netutil.bind_sockets(0, '127.0.0.1', socket.AF_INET)
            self.port = sockets[0].getsockname()[1]
            live.server(self.board, CODE, TOKEN).add_sockets(sockets)
            started.set()
            self.ended = asyncio.Event()
            await self.ended.wait()
        self._thread = threading.Thread(target=self.loop.run_until_complete, args=(start(),))
        self._thread.start()
        assert started.wait(TIMEOUT)

    def end(self):
        self.loop.call_soon_threadsafe(self.ended.set)
        self._thread.join()

    def address(self, code=CODE):
        return f'http://127.0.0.1:{self.port}/{code}'

    def ask(self, method, path, body=None, headers=None, source='127.0.0.1'):
        connection = http.client.HTTPConnection('127.0.0.1', self.port, TIMEOUT, (source, 0))
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        finally:
            connection.close()

    def post(self, content, **how):
        return self.ask('POST', f'/{CODE}', content if isinstance(content, bytes) else json.dumps(content), **how)

    def page(self):
        status, text = self.ask('GET', f'/view/{TOKEN}')
        assert status == 200
        return text


@pytest.fixture(name='served')
def fixture_served():
    served = Served()
    yield served
    served.end()


def test_the_last_grading_of_each_student_is_on_the_page(served):
    assert 'Nobody has reported yet' in served.page()
    for student, decided in (('anna', FAILED), ('anna', PASSED), ('ben', FAILED)):
        live.report(served.address(), student, 'stop_at_x', decided)
    text = served.page()
    assert '>100 (2.)</td>' in text and '>40</td>' in text and '1 passed' in text
    assert 'a secret' not in text and 'these are no grades' in text


def test_names_are_text(served):
    hostile = '<script>alert(1)</script>\x1b[2J\u202e' + 'x' * 100
    assert served.post({**REPORT, 'student': hostile, 'exercise': hostile, 'reason': '" onclick="'})[0] == 204
    text = served.page()
    assert '<script>alert' not in text and '\x1b' not in text and '\u202e' not in text and '" onclick="' not in text
    assert '&lt;script&gt;' in text and 'x' * 61 not in text


@pytest.mark.parametrize('method, path, status', [
    ('POST', '/abcdefghij', 404), ('POST', f'/{TOKEN}', 404), ('POST', f'/view/{TOKEN}', 405),
    ('GET', f'/view/{CODE}', 404), ('GET', f'/{CODE}', 405), ('GET', '/', 404), ('GET', '/view/', 404)])
def test_only_who_knows_the_secret_can_report_or_read(served, method, path, status):
    assert served.ask(method, path, json.dumps(REPORT) if method == 'POST' else None)[0] == status
    assert 'anna' not in served.page()


@pytest.mark.parametrize('content', [
    b'', b'{', b'[]', b'[' * 2000, b'{"student": "anna"}', b'\xff', {**REPORT, 'student': ' '},
    {**REPORT, 'student': 3}, {**REPORT, 'score': 101}, {**REPORT, 'score': 'nan'}, {**REPORT, 'outcome': 'best'},
    {**REPORT, 'outcome': []}])
def test_impossible_reports_are_refused(served, content):
    status, said = served.post(content)
    assert status == 400 and 'report' in said
    assert 'anna' not in served.page() and '1 reports were refused' in served.page()


def test_a_flood_is_refused_and_others_are_heard(served):
    found = [served.post(REPORT)[0] for _ in range(MAX_REPORTS + 10)]
    assert found == [204] * MAX_REPORTS + [429] * 10
    assert served.post({**REPORT, 'student': 'ben'}, source='127.0.0.2')[0] == 204
    assert '>ben</th>' in served.page() and '10 reports were refused' in served.page()


def test_a_flood_ends():
    now = [0.0]
    board = Board(lambda: now[0])
    for _ in range(MAX_REPORTS):
        board.take(json.dumps(REPORT).encode(), 'a')
    with pytest.raises(live.Refused):
        board.take(json.dumps(REPORT).encode(), 'a')
    now[0] = live.WINDOW
    board.take(json.dumps(REPORT).encode(), 'a')


def test_invented_students_do_not_fill_the_memory():
    board = Board()
    for number in range(MAX_STUDENTS):
        board.take(json.dumps({**REPORT, 'student': f's{number}'}).encode(), f'{number % 99}')
    with pytest.raises(live.Refused, match='reports of 400 students'):
        board.take(json.dumps({**REPORT, 'student': 'one more'}).encode(), 'b')
    board.take(json.dumps({**REPORT, 'student': 's7'}).encode(), 'b')  # who is known goes on
    for number in range(3 * MAX_STUDENTS):
        with pytest.raises(live.Refused):
            board.take(b'', f'address {number}')
    assert len(board._times) <= live.MAX_ADDRESSES + 1


def test_bodies_and_headers_that_are_too_large_are_not_read(served):
    large = b'x' * (10 << 20)
    for headers, body in (({}, large), ({'X-Long': 'x' * 20_000}, b'{}'),
                          ({'Transfer-Encoding': 'chunked'}, iter([b'x' * 1500] * 4))):
        try:
            assert served.ask('POST', f'/{CODE}', body, headers)[0] in (400, 413, 431)
        except (ConnectionError, http.client.HTTPException):
            pass  # it was closed while the rest was still sent
    live.report(served.address(), 'anna', 'stop_at_x', PASSED)


def test_connections_that_send_nothing_hold_up_nobody(served):
    idle = [socket.create_connection(('127.0.0.1', served.port), TIMEOUT) for _ in range(100)]
    for one in idle[:50]:
        one.sendall(f'POST /{CODE} HTTP/1.1\r\nContent-Length: 100\r\n\r\n{{'.encode())
    live.report(served.address(), 'anna', 'stop_at_x', PASSED)
    for one in idle:
        one.close()


def test_a_report_that_does_not_arrive_says_why(served):
    with pytest.raises(live.ReportError, match='^its code is wrong: copy the address again$'):
        live.report(served.address('abcdefghij'), 'anna', 'x', PASSED)
    with socket.socket() as closed:
        closed.bind(('127.0.0.1', 0))
        address = f'http://127.0.0.1:{closed.getsockname()[1]}/x'
    for wrong, said in ((address, 'refused'), ('http://[/', '.')):
        with pytest.raises(live.ReportError, match=said):
            live.report(wrong, 'anna', 'x', PASSED)


def test_the_command_prints_both_addresses_and_ends_by_ctrl_c():
    run = 'import sys; from course_grader import cli; sys.exit(cli.main(["--live", *sys.argv[1:]]))'
    command = [sys.executable, '-c', run, '--port', '0', '--address', '127.0.0.1']
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True,
                               env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path), 'PYTHONUNBUFFERED': '1'})
    try:
        said = ''.join(process.stdout.readline() for _ in range(4))
        page = re.search(r'http://127\.0\.0\.1:(\d+)(/view/\S+)', said)
        report = re.search(r'export TURTLE_ROBOTONT_REPORT=(\S+)', said)[1]
        live.report(report, '', 'stop_at_x', PASSED)
        connection = http.client.HTTPConnection('127.0.0.1', int(page[1]), TIMEOUT)
        connection.request('GET', page[2])
        assert f'<th scope="row">{live.user()}</th>' in connection.getresponse().read().decode()
        process.send_signal(signal.SIGINT)
        assert process.wait(TIMEOUT) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
