"""doctor.addresses: the address that a machine announces, and why other machines cannot use it."""
import socket

import pytest

from plain_support.doctor import addresses

NO_ADDRESS = '10.88.0.9'  # none of a machine that runs tests


@pytest.mark.parametrize('environment, master, said', [
    ({'ROS_HOSTNAME': 'localhost'}, 'localhost', ''),
    ({'ROS_IP': '127.0.0.1'}, '127.0.0.1', ''),
    ({'ROS_HOSTNAME': 'localhost'}, NO_ADDRESS,
     f'The master is on another machine ({NO_ADDRESS}), but ROS_HOSTNAME is localhost, which other machines cannot'),
    ({'ROS_IP': '127.0.0.1'}, NO_ADDRESS, f'The master is on another machine ({NO_ADDRESS}), but ROS_IP is 127.0.0.1'),
    ({'ROS_IP': NO_ADDRESS}, 'localhost',
     f'ROS_IP is {NO_ADDRESS}, which is not an address of this machine: nodes on other machines cannot reach'),
    ({'ROS_HOSTNAME': 'no-such-name'}, 'localhost', "ROS_HOSTNAME is 'no-such-name', a name that has no address"),
    ({'ROS_HOSTNAME': 'x' * 70}, 'localhost', f"ROS_HOSTNAME is {'x' * 70!r}, a name that has no address"),
])
def test_wrong_addresses_are_named(monkeypatch, environment, master, said):
    lookup = socket.gethostbyname
    monkeypatch.setattr(socket, 'gethostbyname', lambda name: lookup(name if name != 'no-such-name' else 'x' * 70))
    for name in ('ROS_HOSTNAME', 'ROS_IP'):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv('ROS_MASTER_URI', f'http://{master}:11311')
    text = str(addresses.wrong_address() or '')
    assert text.startswith(said) and bool(text) == bool(said)
    if said:
        assert 'export ROS_IP=' in text and ('unset ROS_HOSTNAME' in text) == ('ROS_HOSTNAME' in environment)


@pytest.mark.parametrize('uri, place', [
    ('http://localhost:11311', ('localhost', 11311)), ('http://robot:12345/', ('robot', 12345)),
    ('http://[::1]:12345', ('::1', 12345)), ('', ('localhost', 11311)), ('localhost:11311', None),
    ('https://robot:11311', None), ('http://robot', None), ('http://:11311', None), ('http://robot:port', None),
    ('http://robot:99999', None),
])
def test_master_address_is_read(uri, place):
    found = addresses.master_address({'ROS_MASTER_URI': uri})
    assert (found and (found.host, found.port)) == place


def own_name_is_known():
    """Return whether this machine finds an address for its own name; some do not."""
    try:
        return bool(socket.getaddrinfo(socket.gethostname(), None))
    except OSError:
        return False


@pytest.mark.parametrize('host, here', [
    ('localhost', True), ('127.0.0.1', True), (socket.gethostname(), own_name_is_known()), (NO_ADDRESS, False),
    ('x' * 70, False), ('', False)])
def test_a_machine_knows_its_addresses(host, here):
    assert addresses.is_here(host) is here
