"""Score detectors on the photos of marker_classes, and print the scores by class."""
import numpy as np

from figures import Figure, Target, aligned
from unit_support import marker_classes
from unit_support.marker_classes import KINDS, LOOK_ALIKES, TEST
from unit_support.marker_score import Score, scored
from unit_support.photo import with_gamma

HEADS = ('corner px', 'rotation deg', 'flagged %', 'off', 'wrong, false')
COLUMNS = 1 + len(HEADS)  # of a tool in the table
PER_CLASS = 24  # photos of each class
LOOK_ALIKE_PHOTOS = 35  # for each photo of another class: 10,080 squares
OFF = 5.0  # [degrees] error of a pose that must be flagged


def scores(tools, count, gamma=1.0):
    """Return {tool: {class: Score}} of ``tools``, {name: function (image, camera) that returns detections}.

    ``gamma`` is that of the camera; look-alikes are shown to a linear one only.
    """
    names = (*KINDS, LOOK_ALIKES) if gamma == 1 else KINDS
    out = {tool: {name: Score() for name in names} for tool in tools}
    for name in names:
        for number in range(count * (LOOK_ALIKE_PHOTOS if name == LOOK_ALIKES else 1)):
            shot = marker_classes.photo(name, TEST, number)
            shot = shot._replace(image=with_gamma(shot.image, gamma))
            for tool, detect in tools.items():
                out[tool][name].add(scored([shot], detect))
    return out


def pair(values, form='{:.2f} / {:.2f}'):
    """Return median and 95th percentile as text."""
    return form.format(*np.percentile(values, [50, 95])) if len(values) else '-'


def table(results):
    """Return the table of {tool: {class: Score}} as text: a group of columns for each tool."""
    head = ['class']
    for tool in results:
        head += [f'{tool}: recall %', *HEADS]
    rows = [head]
    for name in next(iter(results.values())):
        row = [name]
        for by_class in results.values():
            row += _columns(by_class[name]) if name in by_class else ['-'] * COLUMNS
        rows.append(row)
    return aligned(rows)


def _columns(score):
    recall = f'{score.recall:.1f}' if score.matches else '-'
    flags = f'{100 * np.mean(score.flags()):.0f}' if score.flags() else '-'
    off = str(sum(turn > OFF for turn in score.rotations(sure=True)))
    return [recall, pair(score.corners()), pair(score.rotations(), '{:.1f} / {:.1f}'), flags, off,
            f'{score.wrong}, {score.false}']


def samples(by_class, key='class'):
    """Return {figure key: samples} of our scores; all keys begin with ``key``."""
    every = Score()
    for score in by_class.values():
        every.add(score)
    return {f'{key}_off': [sum(turn > OFF for turn in every.rotations(sure=True))], f'{key}_flips': [every.flips],
            f'{key}_false': [every.false], f'{key}_wrong': [every.wrong]}


def figures(key, of):
    """Yield the Figures of these; ``of`` says which camera."""
    for name, words in (('off', f'off by {OFF:.0f} degrees without a flag'), ('flips', 'flips'),
                        ('false', 'false positives'), ('wrong', 'wrong ids')):
        yield Figure(f'classes, {of}: {words}', f'{key}_{name}', 'in all', max, Target('below', 1.0))
