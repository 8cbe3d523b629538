"""Who may connect: the rules for Host, Origin and token, and the rate of messages.

* **Host** must be an address, localhost, or a name of this machine. Otherwise a foreign page whose name starts to
  resolve to 127.0.0.1 could read everything (DNS rebinding).
* **Origin**, in which browsers send the page's site, must be this server, localhost, file:// or an installed app.
  Otherwise any site that a student visits could drive the robot. Other programs send no Origin, or that of the server.
  Images of a page come without one: there the page's address counts.
* **Token**: clients on other machines need it in the address: ws://robot:9090/?token=...
"""
import hmac
import ipaddress
import re
import time
import urllib.parse
from typing import Callable, Collection, NamedTuple, Optional

ANY, OFF = 'any', 'off'
LOCAL_NAMES = 'localhost', 'localhost.localdomain'
EVERYWHERE = '0.0.0.0'  # in the address that python3 -m http.server prints
SCHEMES = 'http', 'https', 'ws', 'wss'  # the last two are what ws4py sends, and no browser
APPS = 'capacitor://localhost', 'ionic://localhost', 'tauri://localhost'  # origins of installed apps, so trusted;
EXTENSIONS = 'vscode-webview://'  # and how those of VS Code's extensions begin
HOST = re.compile(r'(\[[0-9a-f:.]+\]|[^][\s/?#@:\\]+)(?::\d{1,5})?', re.IGNORECASE)


class Access(NamedTuple):
    """The rules of a server: ``token`` or OFF; further ``origins``, which may contain ANY; ``hosts``: its names.

    ``null_origin``: allow the origin "null", which Firefox sends for files, and any site can send from a sandbox.
    """

    token: str
    origins: Collection[str] = ()
    hosts: Collection[str] = ()
    null_origin: bool = False

    def refusal(self, peer: str, host: Optional[str], origin: Optional[str], token: Optional[str]) -> Optional[str]:
        """Return why a request is refused, None if it is allowed; ``peer``: the client's address."""
        return self._host_refusal(host) or self._origin_refusal(origin, host or '') or self._token_refusal(peer, token)

    def _host_refusal(self, host: Optional[str]) -> Optional[str]:
        name = host_name(host or '')
        if name and (is_address(name) or name in LOCAL_NAMES or name in {own.lower() for own in self.hosts}):
            return None
        return (f'the Host {host!r} is not a name of this server. Use its address, or '
                f'{_start_with("hosts", name or "NAME")}')

    def _origin_refusal(self, origin: Optional[str], host: str) -> Optional[str]:
        if origin is None or ANY in self.origins or origin in self.origins or origin == 'file://':
            return None
        if origin == 'null' and self.null_origin:
            return None
        if origin in APPS or origin.startswith(EXTENSIONS):
            return None
        scheme, separator, rest = origin.rpartition('://')
        name = host_name(rest)
        local = rest.lower() == host.lower() or is_loopback(name) or name == EVERYWHERE
        if local and (scheme in SCHEMES or not separator):
            return None
        if origin == 'null':
            return ('the Origin "null" can be a file in Firefox, but also any site that hides its name. To allow both, '
                    f'{_start_with("origins", origin)}')
        return f'pages from {origin} may not connect. To allow them, {_start_with("origins", origin)}'

    def _token_refusal(self, peer: str, token: Optional[str]) -> Optional[str]:
        if self.token == OFF or is_loopback(peer):
            return None
        if token is None:
            return 'the token is missing; other machines need it in the address: /?token=TOKEN'
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return 'the token is wrong; the server has printed the right one when it started'
        return None


def _start_with(option: str, value: str) -> str:
    return f'start the server with {option}:={value} (./run view: --{option} {value})'


def host_name(host: str) -> str:
    """Return the name or address of ``name:port``, in lower case; '' if it is invalid."""
    match = HOST.fullmatch(host)
    return match.group(1).strip('[]').rstrip('.').lower() if match else ''


def page_origin(origin: Optional[str], referer: Optional[str], site: Optional[str], mode: Optional[str],
                of_files: bool) -> Optional[str]:
    """Return the Origin of a request; for a foreign page's image, which has none, that of the page; else None.

    ``referer``, ``site`` and ``mode``: the headers Referer, Sec-Fetch-Site and Sec-Fetch-Mode. A page without Referer
    counts as "null", unless ``of_files``: pages that are opened as files send none, like sites that hide their names.
    """
    if origin is not None or site != 'cross-site' or mode == 'navigate':
        return origin
    parts = urllib.parse.urlsplit(referer or '')
    if parts.netloc:
        return f'{parts.scheme}://{parts.netloc}'
    return None if of_files else 'null'


def is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def is_loopback(name: str) -> bool:
    """Return whether a name or address always means this machine."""
    if not is_address(name):
        return name in LOCAL_NAMES
    address = ipaddress.ip_address(name)
    mapped = getattr(address, 'ipv4_mapped', None)
    return (mapped or address).is_loopback


class Rate:
    """A limit for the messages of a client: ``rate`` [1/s] on average, ``burst`` at once."""

    def __init__(self, rate: float, burst: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._burst, self._clock = rate, burst, clock
        self._left, self._seen = burst, clock()

    def admits(self) -> bool:
        """Return whether another message is within the limit, and count it if it is."""
        self._refill()
        if self._left < 1:
            return False
        self._left -= 1
        return True

    def pause(self) -> float:
        """Count a message; return how long [s] the client has to wait before the next one is read."""
        self._refill()
        self._left -= 1
        return max(0.0, -self._left / self._rate)

    def _refill(self) -> None:
        now = self._clock()
        self._left = min(self._burst, self._left + (now - self._seen) * self._rate)
        self._seen = now
