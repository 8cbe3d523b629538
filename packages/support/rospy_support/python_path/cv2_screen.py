"""The windows of cv2_windows.py on a display: a process of its own, so that Tk has a main thread, and no other one.

Its standard input has lines of JSON, {"do": ORDER, "window": NAME, ...}; the image of an order "show" follows as PPM or
PGM of so many "bytes". Its standard output has lines [KIND, NAME, VALUE ...]: what a user does in a window. It ends
with its standard input.
"""
import json
import queue
import sys
import threading

POLL_INTERVAL = 10  # [ms] between two looks for orders
CODES = {65293: 13, 65421: 13, 65307: 27, 65288: 8, 65289: 9}  # keysyms of X: codes of waitKey
MODIFIERS = range(65505, 65519)  # Shift, Control and the like alone are no keys
PRESSED, RELEASED, TWICE = {1: 1, 2: 3, 3: 2}, {1: 4, 2: 6, 3: 5}, {1: 7, 2: 9, 3: 8}  # Tk's button: cv2.EVENT_...
FLAGS = {0x100: 1, 0x400: 2, 0x200: 4, 0x4: 8, 0x1: 16, 0x8: 32}  # Tk's state: cv2.EVENT_FLAG_...


def report(*values):
    """Tell the program."""
    print(json.dumps(values), flush=True)


class Window:
    """A window with its image, and its trackbars above it."""

    def __init__(self, tkinter, root, name):
        self._tkinter, self._name, self._scales = tkinter, name, {}
        self.top = tkinter.Toplevel(root)
        self.top.title(name)
        self.top.resizable(False, False)
        self._image = None
        self._label = tkinter.Label(self.top, borderwidth=0, highlightthickness=0, padx=0, pady=0)
        self._label.pack(side='bottom')
        self.top.bind('<Key>', self._press)
        for sequence, events in (('ButtonPress', PRESSED), ('ButtonRelease', RELEASED), ('Double-ButtonPress', TWICE)):
            self._label.bind(f'<{sequence}>', lambda event, events=events: self._click(events.get(event.num), event))
        self._label.bind('<Motion>', lambda event: self._click(0, event))

    def _press(self, event):
        if event.keysym_num not in MODIFIERS:
            report('key', self._name, CODES.get(event.keysym_num, event.keysym_num))

    def _click(self, number, event):
        if number is not None:
            flags = sum(flag for bit, flag in FLAGS.items() if event.state & bit)
            report('mouse', self._name, number, event.x, event.y, flags)

    def show(self, data):
        """Show an image of the formats PPM or PGM."""
        image = self._tkinter.PhotoImage(data=data, format='PPM')
        self._label.configure(image=image)
        self._image = image  # Tk keeps no reference

    def trackbar(self, name, value, least, most):
        """Add or move a trackbar."""
        if name not in self._scales:
            scale = self._scales[name] = self._tkinter.Scale(self.top, label=name, orient='horizontal')
            scale.pack(fill='x')
        scale = self._scales[name]
        scale.configure(command='')
        scale.configure(from_=least, to=most)
        scale.set(value)
        self.top.update_idletasks()
        scale.configure(command=lambda text: report('trackbar', self._name, name, round(float(text))))


class Screen:
    """All windows; everything but reading happens in Tk's main loop."""

    def __init__(self, tkinter):
        self._tkinter, self._windows, self._orders = tkinter, {}, queue.Queue()
        self._root = tkinter.Tk(className='cv2')
        self._root.withdraw()
        threading.Thread(target=self._read, daemon=True).start()
        self._poll()

    def run(self):
        """Show windows until the program ends."""
        self._root.mainloop()

    def _read(self):
        for line in sys.stdin.buffer:
            order = json.loads(line)
            size = order.pop('bytes', 0)
            if size:
                order['data'] = sys.stdin.buffer.read(size)
            self._orders.put(order)
        self._orders.put(None)

    def _poll(self):
        while not self._orders.empty():
            order = self._orders.get()
            if order is None:
                self._root.destroy()
                return
            self._carry_out(order.pop('do'), order.pop('window'), order)
        self._root.after(POLL_INTERVAL, self._poll)

    def _carry_out(self, what, name, values):
        if what == 'open':
            window = self._windows[name] = Window(self._tkinter, self._root, name)
            window.top.protocol('WM_DELETE_WINDOW', lambda: report('close', name))
        window = self._windows.get(name)
        if window is None:
            return
        if what == 'show':
            window.show(**values)
        elif what == 'trackbar':
            window.trackbar(**values)
        elif what == 'move':
            window.top.geometry(f'+{values["x"]}+{values["y"]}')
        elif what == 'title':
            window.top.title(values['title'])
        elif what == 'close':
            self._windows.pop(name).top.destroy()


def main():
    """Run the process; exit with a text that says why, if there is no window."""
    try:
        import tkinter
        screen = Screen(tkinter)
    except ImportError as error:
        sys.exit(f"cv2: no window: Python's tkinter is missing ({error}). Type: sudo apt-get install python3-tk")
    except tkinter.TclError as error:
        sys.exit(f'cv2: no window: {error}. ./run view shows the images in a browser.')
    screen.run()


if __name__ == '__main__':
    main()
