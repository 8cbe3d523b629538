"""The results of a bench: a table for people, JSON for programs. No ROS."""

import json
import os
import platform
import re
import time

from figures import OURS, PEER

HEADER = ('figure', 'ours', 'peer', 'ratio', 'target', 'ok?')


def number(value):
    """Return a figure as text: four significant digits, a comma for thousands, '-' for none."""
    if value is None:
        return '-'
    if abs(value) >= 1000.0:
        return f'{value:,.0f}'
    return f'{value:.4g}' if abs(value) < 100.0 else f'{value:.1f}'


def cells(row):
    """Return the six texts of a row of the table."""
    figure = row.figure
    ratio = '-' if row.ratio is None else f'{row.ratio:.2f}'
    target = str(figure.target) if figure.target else ''
    verdict = {True: 'yes', False: 'NO', None: '-' if figure.target else ''}[row.ok]
    name = f'{figure.name} [{figure.unit}]' if figure.unit else figure.name
    return (name, number(row.ours), number(row.peer), ratio, target, verdict)


def aligned(rows, right=(), rule=False):
    """Return rows of texts as aligned columns, those of ``right`` at the right; ``rule``: a line below the first."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    if rule:
        rows = [rows[0], ['-' * width for width in widths], *rows[1:]]
    return '\n'.join('  '.join(text.rjust(width) if column in right else text.ljust(width) for column, (text, width)
                               in enumerate(zip(row, widths))).rstrip() for row in rows)


def table(rows):
    """Return the rows as aligned text, without those of which nothing was measured."""
    return aligned([HEADER, *(cells(row) for row in rows if row.ours is not None or row.peer is not None)],
                   right=(1, 2, 3), rule=True)


def verdict(rows):
    """Return the closing sentence: how many targets were reached, missed, and could not be judged."""
    judged = [row for row in rows if row.figure.target]
    reached = sum(row.ok is True for row in judged)
    missed = [row.figure.name for row in judged if row.ok is False]
    text = f'{reached} of {len(judged)} targets reached'
    if missed:
        text += f', {len(missed)} missed ({"; ".join(missed)})'
    open_ones = len(judged) - reached - len(missed)
    if open_ones:
        text += f', {open_ones} not judged (not measured, or a ratio without --peer)'
    return text + '.'


def cpu_model(cpuinfo):
    """Return the processor's name in the text of /proc/cpuinfo; 'unknown' if it has none (some ARM boards)."""
    found = re.search(r'^(?:model name|Model|Hardware)\s*:\s*(.*)$', cpuinfo, re.MULTILINE)
    return found[1] if found else 'unknown'


def machine():
    """Return the facts of this machine that figures depend on; no names, no paths."""
    with open('/proc/cpuinfo', encoding='utf-8', errors='replace') as file:
        model = cpu_model(file.read())
    return {
        'cores': os.cpu_count(),
        'cpu': model,
        'architecture': platform.machine(),
        'python': platform.python_version(),
        'load_before': round(os.getloadavg()[0], 2),
    }


def as_json(suite, rows, failures, settings, facts):
    """Return the whole run as JSON text; rows without samples are null."""
    document = {
        'suite': suite,
        'when': time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime()),
        'machine': facts,
        'settings': settings,
        'figures': [_row_as_dict(row) for row in rows],
        'failures': failures,
    }
    return json.dumps(document, indent=2) + '\n'


def _row_as_dict(row):
    figure = row.figure
    entry = {'name': figure.name, 'key': figure.key, 'unit': figure.unit}
    entry.update(ours=row.ours, peer=row.peer, ratio=row.ratio)
    entry.update(target=str(figure.target) if figure.target else None, ok=row.ok)
    for side in (OURS, PEER):
        entry[f'{side}_samples'] = row.counts[side]
        entry[f'{side}_range'] = row.ranges[side]
    return entry
