"""Who may connect."""
import pytest

from browser_servers.core.access import ANY, OFF, Access, Rate, is_loopback, page_origin

LOCAL, FAR = '127.0.0.1', '192.168.1.7'
ACCESS = Access('secret', hosts=['robot', 'robot.local'])


@pytest.mark.parametrize('host', [
    'localhost:9090', 'LOCALHOST', '127.0.0.1:9090', '[::1]:9090', '192.168.1.5:9090', 'robot:9090', 'Robot.local',
    'localhost.:9090',
])
def test_names_of_this_machine_are_right_hosts(host):
    assert ACCESS.refusal(LOCAL, host, None, None) is None


@pytest.mark.parametrize('host', [
    None, '', 'evil.example:9090', 'localhost.evil.example', '127.0.0.1.evil.example', ':9090', '[::1', 'evil.example@',
    'localhost:9090.evil.example', 'user@localhost', 'localhost:', 'localhost/', '0x7f000001',
])
def test_other_hosts_are_refused(host):
    assert 'is not a name of this server' in ACCESS.refusal(LOCAL, host, None, None)


@pytest.mark.parametrize('origin', [
    None, 'http://localhost', 'http://localhost:8000', 'https://127.0.0.1:3000', 'http://[::1]:80', 'file://',
    'http://robot:9090', 'http://0.0.0.0:8000',
    'ws://robot:9090', 'wss://robot:9090', 'ws://127.0.0.1:9090', 'robot:9090', 'localhost:9090',  # not of browsers
    'capacitor://localhost', 'ionic://localhost', 'tauri://localhost', 'vscode-webview://1abc',  # installed apps
])
def test_own_and_local_pages_may_connect(origin):
    assert ACCESS.refusal(LOCAL, 'robot:9090', origin, None) is None


@pytest.mark.parametrize('origin', [
    'http://evil.example', 'https://localhost.evil.example', 'http://robot:80', 'chrome-extension://abc', 'null', '',
    'http://localhost@evil.example', 'file://evil', 'ftp://localhost', 'http://127.0.0.1.evil.example',
    'http://localhost:12210.evil.example', 'http://user@localhost', 'ws://evil.example', 'evil.example',
    'ftp://http://localhost', 'http://0.0.0.0.evil.example', 'tauri://localhost.evil.example',
])
def test_foreign_pages_are_refused(origin):
    assert 'start the server with' in ACCESS.refusal(LOCAL, 'robot:9090', origin, None)


def test_a_refusal_says_what_to_type():
    host = ACCESS.refusal(LOCAL, 'hub.example:8000', None, None)
    origin = ACCESS.refusal(LOCAL, 'robot', 'https://hub.example', None)
    assert 'hosts:=hub.example (./run view: --hosts hub.example)' in host
    assert 'origins:=https://hub.example (./run view: --origins https://hub.example)' in origin


@pytest.mark.parametrize('changed, origin', [
    ({'origins': ['http://class.example']}, 'http://class.example'), ({'origins': [ANY]}, 'http://evil.example'),
    ({'null_origin': True}, 'null'), ({'origins': ['null']}, 'null'),
])
def test_other_origins_can_be_allowed(changed, origin):
    assert ACCESS._replace(**changed).refusal(LOCAL, 'robot:9090', origin, None) is None


@pytest.mark.parametrize('peer, token, error', [
    (FAR, None, 'the token is missing'), (FAR, '', 'the token is wrong'), (FAR, 'Secret', 'wrong'),
    (FAR, 'sécret', 'wrong'),
])
def test_other_machines_need_the_token(peer, token, error):
    assert error in ACCESS.refusal(peer, 'robot:9090', None, token)


@pytest.mark.parametrize('peer, token', [
    (LOCAL, None), ('::1', None), ('::ffff:127.0.0.1', None), (FAR, 'secret')])
def test_this_machine_needs_no_token_and_others_the_right_one(peer, token):
    assert ACCESS.refusal(peer, 'robot:9090', None, token) is None


def test_token_can_be_switched_off_by_name():
    assert Access(OFF).refusal(FAR, '192.168.1.5:9090', None, None) is None


@pytest.mark.parametrize('name, found', [
    ('127.9.9.9', True), ('::1', True), ('localhost', True), ('0.0.0.0', False), ('10.0.0.1', False), ('', False)])
def test_loopback(name, found):
    assert is_loopback(name) is found


def test_rate_allows_a_burst_and_then_its_average():
    now = [0.0]
    rate = Rate(100.0, 10, lambda: now[0])
    assert [rate.pause() for _ in range(10)] == [0.0] * 10
    assert rate.pause() == pytest.approx(0.01)
    now[0] = 0.02
    assert rate.pause() == pytest.approx(0.0)


@pytest.mark.parametrize('origin, referer, site, mode, of_files, found', [
    (None, None, None, None, False, None),  # no browser
    (None, None, 'same-origin', 'no-cors', False, None), (None, None, 'none', 'navigate', False, None),
    (None, 'http://localhost:5500/', 'same-site', 'no-cors', False, None),
    (None, 'http://evil.example/a', 'cross-site', 'navigate', False, None),  # a link that somebody follows
    (None, 'http://evil.example/a', 'cross-site', 'no-cors', False, 'http://evil.example'),  # an image
    (None, 'http://evil.example/a', 'cross-site', 'no-cors', True, 'http://evil.example'),
    (None, None, 'cross-site', 'no-cors', False, 'null'), (None, None, 'cross-site', 'no-cors', True, None),
    ('http://evil.example', None, 'cross-site', 'cors', True, 'http://evil.example'),
])
def test_an_image_has_the_origin_of_its_page(origin, referer, site, mode, of_files, found):
    assert page_origin(origin, referer, site, mode, of_files) == found
