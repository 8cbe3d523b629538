"""The bench of the grader's hints: how many mistakes of beginners get the right advice.

The programs of test/data/wrong_programs.yaml are right samples of the course with one mistake each; they
were written before any symptom was. Those of unseen_programs.yaml are whole programs in other styles, written from the
tasks' texts alone; symptoms were written for them after they were counted. Those of held_out_programs.yaml were written
and counted after that; docs/measurements.md says what was fixed after their count. Those of developed_programs.yaml
are whole programs by somebody who did not know the symptoms; kinds of mistakes that got no hint were fixed. Those of
untouched_programs.yaml are by the same author: nobody read them before they were counted.
"""

import json
import random
import re
import sys
import tempfile
from pathlib import Path

import yaml

import mutations
from figures import Figure, Target
from processes import BenchError
from session import Measurement
from suite_grading import BORDERLINE, CLASS_JOBS, LIMIT, REAL_TIME, REPOSITORY, SEED, grade
from unit_support import course_files  # on the path since suite_grading

NEEDS_NODE = False
PROGRAMS = REPOSITORY / 'test' / 'data' / 'wrong_programs.yaml'
WHOLE = {'unseen': 'unseen_programs.yaml', 'held_out_whole': 'held_out_programs.yaml',
         'developed': 'developed_programs.yaml', 'untouched': 'untouched_programs.yaml'}  # in the same folder
FULL, QUICK = None, 6  # programs of each half
KINDS = {'open': 'mistakes that symptoms were written for', 'held_out': 'mistakes that once were held out',
         'unseen': 'whole programs that once were held out', 'held_out_whole': 'whole programs of all exercises',
         'developed': 'whole programs that hints were developed with',
         'untouched': 'whole programs that nobody looked at before'}


def programs(kind):
    """Return [(exercise, text of the program, pattern of the right hint)]."""
    if kind in WHOLE:
        return [(entry['exercise'], entry['program'], entry['hint'])
                for entry in yaml.safe_load((PROGRAMS.parent / WHOLE[kind]).read_text(encoding='utf-8'))]
    found = []
    for entry in yaml.safe_load(PROGRAMS.read_text(encoding='utf-8'))[kind]:
        text = course_files.sample(entry['of']).read_text(encoding='utf-8')
        for old, new in entry['change'].items():
            if str(old) not in text:
                raise BenchError(f'{PROGRAMS}: {entry["of"]} has no {old!r}')
            text = text.replace(str(old), str(new))
        found.append((entry['of'].partition('/')[0], text, entry['hint']))
    return found


def count(kind):
    """Return the measurement of one half: 100 for each program with the right hint, else 0."""
    def run(_subject, most):
        chosen = programs(kind)[:most]
        results = _graded([(exercise, text) for exercise, text, _ in chosen], accepted=(1,))
        return {kind: [_right(result, hint) for result, (_, _, hint) in zip(results, chosen)],
                **_certain([(result, hint) for result, (_, _, hint) in zip(results, chosen)])}
    return run


def count_mutations(kind):
    """Return the measurement of a kind of mistake: whether its hint is the first, is there, or others are instead."""
    def run(_subject, most):
        held_out = kind in mutations.HELD_OUT
        wanted, chosen = {**mutations.KINDS, **mutations.HELD_OUT}[kind].hint, []
        total = 'held out ' if held_out else ''
        for path in course_files.programs('right', '*.py'):
            text = mutations.mutate(kind, path.read_text(encoding='utf-8'))
            if text and path.stem not in (*REAL_TIME, BORDERLINE):
                chosen.append((course_files.exercise_of(path), text))
        if most is not None and most < len(chosen):  # others than the first ones, which are of few exercises
            chosen = random.Random(kind).sample(chosen, most)
        wrong = [result for result in _graded(chosen, accepted=(0, 1, 3)) if result['outcome'] == 'failed']
        right = [[bool(re.search(wanted, hint)) for hint in result['hints']] for result in wrong]
        for result, hints in zip(wrong, right):
            if not any(hints[:1]):
                print(f'    {result["exercise"]}, {kind}: {result["hints"]}', file=sys.stderr)
        return {f'first {kind}': [100.0 * any(hints[:1]) for hints in right], **({
            f'{total}first': [100.0 * any(hints[:1]) for hints in right],
            f'{total}named': [100.0 * any(hints) for hints in right],
            f'{total}misled': [100.0 * (bool(hints) and not any(hints)) for hints in right],
            **_certain([(result, wanted) for result in wrong])} if right else {})}
    return run


def _certain(results):
    """Return the samples of the mistakes that are told as certain, of [(result, pattern of the right hint)]."""
    told = [(result['hints'][0], wanted) for result, wanted in results if result['certain']]
    for hint, wanted in told:
        if not re.search(wanted, hint):
            print(f'    told as certain, instead of {wanted!r}: {hint}', file=sys.stderr)
    return {'certain': [100.0 * bool(re.search(wanted, hint)) for hint, wanted in told]} if told else {}


def _graded(programs_, accepted):
    """Grade programs, [(exercise, text)], as a class; return their results."""
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_bench_') as folder:
        for number, (exercise, text) in enumerate(programs_):
            student = Path(folder, 'class', f'{number:03}')
            student.mkdir(parents=True)
            (student / f'{exercise}.py').write_text(text, encoding='utf-8')
        grade(['--all', str(Path(folder, 'class')), '--seed', str(SEED), '--jobs', str(CLASS_JOBS), '--output',
               str(Path(folder, 'out'))], LIMIT * (2 + len(programs_)), accepted=accepted)
        return [json.loads(Path(folder, 'out', f'{number:03}', exercise, 'result.json').read_text(encoding='utf-8'))
                for number, (exercise, _) in enumerate(programs_)]


def _right(result, wanted):
    """Return 100 if a result has the hint, else 0; print the hints that it has."""
    if any(re.search(wanted, hint) for hint in result['hints']):
        return 100.0
    print(f'    {result["exercise"]}: {result["outcome"]}; wanted {wanted!r}, got {result["hints"]}', file=sys.stderr)
    return 0.0


def mean(values):
    return sum(values) / len(values)


MEASUREMENTS = {**{kind: Measurement(count(kind), about) for kind, about in KINDS.items()},
                **{f'kind {kind}': Measurement(count_mutations(kind), f'the mistake "{kind}" in all right samples')
                   for kind in (*mutations.KINDS, *mutations.HELD_OUT)}}
FIGURES = (
    *(Figure(f'right hints, {about}', kind, '%', mean, Target('at_least', 90.0)) for kind, about in KINDS.items()),
    *(Figure(f'right first hint, {kind}', f'first {kind}', '%', mean)
      for kind in (*mutations.KINDS, *mutations.HELD_OUT)),
    Figure('right among mistakes told as certain', 'certain', '%', mean, Target('at_least', 98.0)),
    Figure('right first hint, all kinds of mistakes', 'first', '%', mean, Target('at_least', 90.0)),
    Figure('right hint among two, all kinds', 'named', '%', mean),
    Figure('only other hints, all kinds', 'misled', '%', mean, Target('at_most', 2.0)),
    *(Figure(f'{about}, kinds that were held out', f'held out {name}', '%', mean, target) for about, name, target in (
        ('right first hint', 'first', Target('at_least', 90.0)), ('right hint among two', 'named', None),
        ('only other hints', 'misled', Target('at_most', 2.0)))),
)
