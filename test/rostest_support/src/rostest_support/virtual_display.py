"""A screen for tests: an X server without hardware (Xvfb), its pixels and its windows.

It uses libX11, which comes with python3-tk, so that a test only needs Xvfb in addition.
"""
import ctypes
import ctypes.util
import os
import shutil
import struct
import subprocess
import tempfile

WIDTH, HEIGHT = 640, 560  # [px]
MISSING = '' if shutil.which('Xvfb') else 'Xvfb is missing, the window is NOT tested: sudo apt install xvfb'

_CLIENT_MESSAGE = 33
_ERROR_HANDLER = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
# A window may vanish between two requests; by default, libX11 would then end the whole test run.
_ignore_errors = _ERROR_HANDLER(lambda _display, _event: 0)


class _ClientMessage(ctypes.Structure):
    _fields_ = [('type', ctypes.c_int), ('serial', ctypes.c_ulong), ('send_event', ctypes.c_int),
                ('display', ctypes.c_void_p), ('window', ctypes.c_ulong), ('message_type', ctypes.c_ulong),
                ('format', ctypes.c_int), ('data', ctypes.c_long * 5), ('rest', ctypes.c_long * 24)]


class VirtualDisplay:
    """A private X server on a free display; ``name`` is the value for DISPLAY. Use it in a with statement."""

    def __init__(self):
        self._display = None
        self._directory = tempfile.mkdtemp()
        self.process = subprocess.Popen(
            ['Xvfb', '-displayfd', '1', '-screen', '0', f'{WIDTH}x{HEIGHT}x24', '-fbdir', self._directory,
             '-nolisten', 'tcp', '-noreset'], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        number = self.process.stdout.readline().strip().decode()
        if not number:
            self.close()
            raise RuntimeError('Xvfb ended without offering a display')
        self.name = f':{number}'
        self._x = _library()
        self._display = self._x.XOpenDisplay(self.name.encode())

    def pixel(self, x, y):
        """Return the colour (r, g, b) on the screen, in px from the upper left corner."""
        with open(os.path.join(self._directory, 'Xvfb_screen0'), 'rb') as file:
            header = struct.unpack('>25I', file.read(100))
            header_size, little_endian, row_bytes, colours = header[0], header[7] == 0, header[12], header[19]
            file.seek(header_size + 12 * colours + row_bytes * y + 4 * x)
            value = file.read(4)
        blue, green, red = value[:3] if little_endian else value[:0:-1]
        return red, green, blue

    def windows(self, title):
        """Return the ids of the windows with this title."""
        root, parent, number = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_uint()
        children = ctypes.POINTER(ctypes.c_ulong)()
        self._x.XQueryTree(self._display, self._x.XDefaultRootWindow(self._display), ctypes.byref(root),
                           ctypes.byref(parent), ctypes.byref(children), ctypes.byref(number))
        return [window for window in children[:number.value] if self._title(window) == title]

    def _title(self, window):
        title = ctypes.c_char_p()
        self._x.XFetchName(self._display, window, ctypes.byref(title))  # leaves NULL for a window that has gone
        return (title.value or b'').decode()

    def size(self, window):
        """Return (width, height) of a window in px."""
        root, x, y, width, height, border, depth = (ctypes.c_ulong(), *(ctypes.c_uint() for _ in range(6)))
        self._x.XGetGeometry(self._display, window, *map(ctypes.byref, (root, x, y, width, height, border, depth)))
        return width.value, height.value

    def ask_to_close(self, window):
        """Request a window to close, as the button in its frame does."""
        protocols = self._x.XInternAtom(self._display, b'WM_PROTOCOLS', 0)
        delete = self._x.XInternAtom(self._display, b'WM_DELETE_WINDOW', 0)
        event = _ClientMessage(type=_CLIENT_MESSAGE, send_event=1, display=self._display, window=window,
                               message_type=protocols, format=32, data=(delete, 0, 0, 0, 0))
        self._x.XSendEvent(self._display, window, 0, 0, ctypes.byref(event))
        self._x.XFlush(self._display)

    def close(self):
        """End the server; its windows lose their connection."""
        if self._display:  # close it first: libX11 ends a program that uses a lost connection
            self._x.XCloseDisplay(self._display)
            self._display = None
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()
        shutil.rmtree(self._directory, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def _library():
    x = ctypes.CDLL(ctypes.util.find_library('X11'))
    display, window, pointer = ctypes.c_void_p, ctypes.c_ulong, ctypes.c_void_p
    for name, result, arguments in (
            ('XOpenDisplay', display, [ctypes.c_char_p]),
            ('XCloseDisplay', ctypes.c_int, [display]),
            ('XDefaultRootWindow', window, [display]),
            ('XQueryTree', ctypes.c_int, [display, window] + [pointer] * 4),
            ('XFetchName', ctypes.c_int, [display, window, pointer]),
            ('XGetGeometry', ctypes.c_int, [display, window] + [pointer] * 7),
            ('XInternAtom', ctypes.c_ulong, [display, ctypes.c_char_p, ctypes.c_int]),
            ('XSendEvent', ctypes.c_int, [display, window, ctypes.c_int, ctypes.c_long, pointer]),
            ('XFlush', ctypes.c_int, [display])):
        function = getattr(x, name)
        function.restype, function.argtypes = result, arguments
    x.XSetErrorHandler(_ignore_errors)
    return x
