"""Recordings of simulators: CSV files with one row a tick, what took effect in it and who asked for it.

Columns: ``tick``, ``event`` (several are separated by ``;``, each a name and its values), those of the simulator, and
``callers``, the nodes that asked for the events, in the same order.
"""
import csv


class Recorder:
    """Writes one recording. Not thread-safe: whoever shares the world locks it for both."""

    def __init__(self, path, columns):
        """Begin the file; ``columns``: names of the simulator's own. Raise OSError when that cannot be."""
        self._file = open(path, 'w', buffering=1, newline='', encoding='utf-8')  # whole lines, for those who read along
        self._writer = csv.writer(self._file, lineterminator='\n')
        self._writer.writerow(('tick', 'event', *columns, 'callers'))
        self._events = []  # [name, values, caller] since the last tick

    def note(self, event, *values, caller=''):
        """Keep an event for the next tick. Of commands in a row only the last counts."""
        if event.rpartition('/')[2] == 'cmd' and self._events and self._events[-1][0] == event:
            self._events.pop()
        self._events.append([event, values, caller])

    def tick(self, number, fields):
        """Write the row of a tick with the simulator's fields; raise OSError when it cannot be written."""
        events = ';'.join(' '.join((name, *map(_text, values))) for name, values, _ in self._events)
        callers = ';'.join(caller for _, _, caller in self._events)
        self._events = []
        self._writer.writerow((number, events, *fields, callers))

    def close(self):
        """End the file."""
        self._file.close()


def _text(value):
    return repr(value) if isinstance(value, float) else str(value)
