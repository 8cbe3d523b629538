"""Which ports of a machine answer, asked from outside (TCP), and which sockets of it wait for anybody (TCP and UDP)."""
import errno
import ipaddress
import re
import selectors
import socket
import sys
import time

AT_ONCE = 500  # connections that are being tried
PORTS = 65536
MAX_SILENCE = 20.0  # [s] without any answer, not even a refused connection


def open_ports(address):
    """Return the TCP ports of an address to which a connection can be made."""
    found, waiting = [], selectors.DefaultSelector()
    ports = iter(range(1, PORTS))
    family = socket.AF_INET6 if ':' in address else socket.AF_INET
    answered = time.monotonic()
    while True:
        while len(waiting.get_map()) < AT_ONCE:
            port = next(ports, None)
            if port is None:
                break
            connection = socket.socket(family)
            connection.setblocking(False)
            result = connection.connect_ex((address, port))
            if result == errno.EINPROGRESS:
                waiting.register(connection, selectors.EVENT_WRITE, port)
            else:
                connection.close()
        if not waiting.get_map():
            return found
        if time.monotonic() > answered + MAX_SILENCE:
            raise TimeoutError(f'{len(waiting.get_map())} ports of {address} do not answer at all: is it there?')
        for key, _ in waiting.select(1.0):
            if key.fileobj.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == 0:
                found.append(key.data)
            answered = time.monotonic()
            waiting.unregister(key.fileobj)
            key.fileobj.close()


def exposed(lines):
    """Return {(protocol, address, program)} of the sockets in ``lines``, of ss -Hlntup, that are not on loopback."""
    found = set()
    for fields in map(str.split, lines):
        address = re.sub(r'%.*|[][]', '', fields[4].rpartition(':')[0])
        parsed = ipaddress.ip_address('0.0.0.0' if address == '*' else address)
        if not (getattr(parsed, 'ipv4_mapped', None) or parsed).is_loopback:
            program = re.search(r'"([^"]*)"', fields[-1])
            found.add((fields[0], fields[4], program[1] if program else '?'))
    return found


def main():
    """As a program, on the machine outside: print the open ports of the addresses in the arguments, one a line."""
    for address in sys.argv[1:]:
        for port in open_ports(address):
            print(f'{address} {port}', flush=True)


if __name__ == '__main__':
    main()
