"""Score detectors on the photos of marker_classes, and print the scores by class."""
import numpy as np

from aruco_baseline import ArucoBaseline
from figures import Figure, Target, median, p95
from report import aligned
from unit_support import marker_classes
from unit_support.marker_classes import KINDS, LIGHT, LOOK_ALIKES, PAPER, SIZE, TEST
from unit_support.marker_score import Score, detector_of, scored
from unit_support.photo import with_gamma

HEADS = ('corner px', 'rotation deg', 'flagged %', 'off', 'wrong, false')
COLUMNS = 1 + len(HEADS)  # of a tool in the table
PER_CLASS = 24  # photos of each class
LOOK_ALIKE_PHOTOS = 35  # for each photo of another class: 10,080 squares
OFF = 5.0  # [degrees] error of a pose that must be flagged
TINY = '10 to 13.5 px'
SHADOWS = ('shadow 0.5', 'shadow 0.35', 'shadow 0.2', 'soft shadow', 'pole')


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


def tools():
    """Return {tool: function (image, camera)} of this project's detector and of OpenCV's."""
    baseline = ArucoBaseline()
    return {'here': detector_of(SIZE), 'ArUco': lambda image, camera: baseline.detect(image, camera, SIZE)}


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
    lines = [aligned(rows)]
    for tool, by_class in results.items():
        times = [each for name in KINDS for each in by_class[name].ms]
        if not times:
            continue
        lines.append('{}: CPU of an image with a marker, ms: median {:.2f}, 95th percentile {:.2f}'.format(
            tool, *np.percentile(times, [50, 95])))
    return '\n'.join(lines)


def _columns(score):
    recall = f'{score.recall:.1f}' if score.matches else '-'
    flags = f'{100 * np.mean(score.flags()):.0f}' if score.flags() else '-'
    off = str(sum(turn > OFF for turn in score.rotations(sure=True)))
    return [recall, pair(score.corners()), pair(score.rotations(), '{:.1f} / {:.1f}'), flags, off,
            f'{score.wrong}, {score.false}']


RECALLS = {  # key: words, limit [%], classes
    'shadows': ('shadows', 95, SHADOWS), 'blinds': ('blinds', 90, ['blinds']),
    'margin': ('thin margins', 99, ['thin margin']), 'small': ('13 to 20 px', 80, ['13 to 20 px']),
    TINY: (TINY, 80, [TINY]), 'laminate': ('laminate', 50, ['laminate']), 'tape': ('tape', 70, ['tape']),
    'faded toner': ('faded toner', 80, ['faded toner']), 'backlight': ('backlight', 90, ['backlight']),
    'pole': ('pole', 95, ['pole']), 'flush paper': ('paper flush with one side', 90, ['flush paper'])}


def samples(by_class, key='class'):
    """Return {figure key: samples} of our scores; all keys begin with ``key``."""
    def of(names):
        total = Score()
        for name in names:
            total.add(by_class[name])
        return total
    light, paper, every = of(LIGHT), of(PAPER), of(by_class)
    good = of(set(KINDS) - {TINY}).flags(good_only=True)  # TINY has two poses nearly always
    return {f'{key}_{name}': values for name, values in {
        **{f'recall_{name}': [of(names).recall] for name, (_, _, names) in RECALLS.items()},
        'corner_light': light.corners() or [np.inf], 'rotation_light': light.rotations(sure=True) or [np.inf],
        'corner_paper': paper.corners() or [np.inf],
        'rotation_bent': of(['bent 10 cm']).rotations(sure=True) or [np.inf],
        'rotation_creased': of(['bent 6 cm', 'creased']).rotations(sure=True) or [np.inf],
        'off': [sum(turn > OFF for turn in every.rotations(sure=True))], 'flips': [every.flips],
        'flagged_good': [100.0 * float(np.mean(good or [0]))], 'false': [every.false], 'wrong': [every.wrong]}.items()}


def figures(key, of):
    """Yield the Figures of these; ``of`` says which camera."""
    for name, (words, limit, _) in RECALLS.items():
        yield Figure(f'recall, {words}, {of}', f'{key}_recall_{name}', '%', median, Target('at_least', limit))
    for name, words, unit, pool, limit in (
            ('corner_light', f'worst corner in bad light, {of}, median', 'px', median, 0.15),
            ('rotation_light', f'rotation in bad light, {of}, median', 'degrees', median, 1.0),
            ('corner_light', f'worst corner in bad light, {of}, 95th percentile', 'px', p95, 0.6),
            ('corner_paper', f'worst corner on bent paper, {of}, median', 'px', median, 0.5),
            ('rotation_bent', f'rotation, bent, radius 10 cm, {of}, median', 'degrees', median, 1.5),
            ('rotation_creased', f'rotation, radius 6 cm and creased, {of}, median', 'degrees', median, 3.0),
            ('off', f'classes, {of}: off by 5 degrees without a flag', 'in all', max, 1.0),
            ('flips', f'classes, {of}: flips', 'in all', max, 1.0),
            ('false', f'classes, {of}: false positives', 'in all', max, 1.0),
            ('wrong', f'classes, {of}: wrong ids', 'in all', max, 1.0),
            ('flagged_good', f'classes, {of}: flagged, but right', '%', max, 3.0)):
        yield Figure(words, f'{key}_{name}', unit, pool, Target('below', limit))
