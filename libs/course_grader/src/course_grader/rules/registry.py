"""All rules by the names that ``checks`` of an exercise file may have, with their parameters: (kind, default)."""
from types import SimpleNamespace
from typing import Any, Dict, Mapping

from course_grader.rules import fits, rules_driving, rules_output
from course_grader.rules.judging import ANY, Result, Rule
from course_grader.rules.observation import Observed

RULES: Dict[str, Rule] = {
    'draws': Rule(rules_driving.draws, {
        'shape': (fits.SHAPES, ...), 'tolerance': ('length', 0.1), 'size': ('span length', ANY)}),
    'commands': Rule(rules_driving.commands, {
        'rate': ('span rate', ANY), 'linear': ('span speed', ANY), 'sideways': ('span speed', ANY),
        'angular': ('span turn speed', ANY), 'turning': ('span turn speed', ANY)}),
    'moves': Rule(rules_driving.moves, {'length': ('length', ...)}),
    'stops': Rule(rules_driving.stops, {
        'x': ('length', None), 'y': ('length', None), 'tolerance': ('length', 0.05), 'rest': ('time', 1.0),
        'size': ('length', 1.0)}),
    'positions': Rule(rules_driving.positions, {
        'count': ('integer', ...), 'apart': ('length', 0.5), 'by': (('teleports', 'driving'), 'teleports')}),
    'pen': Rule(rules_driving.pen, {'colour': ('colour', ...), 'width': ('span pixels', ANY)}),
    'prints': Rule(rules_output.prints, {
        'pattern': ('pattern', ...), 'times': ('integer', 1), 'what': ('text', '')}),
    'prints_poses': Rule(rules_output.prints_poses, {
        'fields': ('integer', 2), 'tolerance': ('length', 0.02), 'share': ('share', 0.8), 'lines': ('integer', 20)}),
    'answers': Rule(rules_output.answers, {
        'service': ('text', ...), 'prints': (('request', 'nothing'), 'nothing'), 'tolerance': ('length', 0.01)}),
    'prints_markers': Rule(rules_output.prints_markers, {
        'what': (('id', 'x'), ...), 'tolerance': ('length', 0.005)}),
    'prints_no_marker': Rule(rules_output.prints_no_marker, {'pattern': ('pattern', r'(?i)\bno\b')}),
    'connects': Rule(rules_output.connects, {
        'topic': ('text', ...), 'role': (('publishes', 'subscribes', 'serves'), ...)}),
    'runs': Rule(rules_output.runs, {'until': (('the end', 'it is done'), 'the end')}),
}


def judge(name: str, observed: Observed, parameters: Mapping[str, Any]) -> Result:
    """Return the Result of the rule ``name`` with {parameter: value}, all of them."""
    return RULES[name].judge(observed, SimpleNamespace(**parameters))
