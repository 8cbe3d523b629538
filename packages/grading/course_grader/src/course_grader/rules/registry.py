"""All rules by their names in ``checks`` of an exercise file, with their parameters."""
from types import SimpleNamespace
from typing import Any, Dict, Mapping

from course_grader.rules import fits, rules_driving, rules_navigation, rules_output, rules_state
from course_grader.rules.judging import ANY, Parameter, Result, Rule
from course_grader.rules.observation import ANGLES, QUANTITIES, Observed

RULES: Dict[str, Rule] = {
    'draws': Rule(rules_driving.draws, {
        'shape': Parameter((*fits.SHAPES, fits.LINE), ..., 'the shape; an eight is two circles that touch'),
        'tolerance': Parameter('length', 0.1, 'how far from the outline the path may be'),
        'size': Parameter('span length', ANY, 'the side; of a circle, and of those of an eight, the diameter'),
        'through': Parameter('points', (), 'of a line, which is asked for at this place: `[[2 m, 3 m], [5 m, 3 m]]`')}),
    'commands': Rule(rules_driving.commands, {
        'rate': Parameter('span rate', ANY, 'commands per second'),
        'linear': Parameter('span speed', ANY, 'linear.x'),
        'sideways': Parameter('span speed', ANY, 'linear.y'),
        'angular': Parameter('span turn speed', ANY, 'angular.z, positive to the left'),
        'turning': Parameter('span turn speed', ANY, 'angular.z to either side, without its sign'),
        'pace': Parameter('span speed', ANY, 'linear.x forward or backward, without its sign'),
        'after': Parameter('name', '', 'the service that the grader calls, before which there may be no command')}),
    'moves': Rule(rules_driving.moves, {'length': Parameter('length', ..., 'the distance')}),
    'stops': Rule(rules_driving.stops, {
        'x': Parameter('coordinate', None, 'where to stop'),
        'y': Parameter('coordinate', None, 'where to stop'),
        'tolerance': Parameter('length', 0.05, 'full points within this distance'),
        'rest': Parameter('time or 0', 1.0, 'how long it has to stand still'),
        'size': Parameter('length', 1.0, 'no points beyond this distance; less than half outside of the tolerance')}),
    'passes': Rule(rules_driving.passes, {
        'x': Parameter('coordinate', None, 'the point'),
        'y': Parameter('coordinate', None, 'the point'),
        'through': Parameter('points', (), 'instead of x and y, several points in this order: `[[2 m, 3 m], '
                             '[5 m, 3 m]]`'),
        'tolerance': Parameter('length', 0.1, 'how far from it the path may be')}),
    'same_path': Rule(rules_driving.same_path, {
        'tolerance': Parameter('length', 0.1, 'how far from it the path may be')}),
    'apart': Rule(rules_driving.apart, {
        'distance': Parameter('length', 0.38, 'between their middles; two Robotonts that touch are 0.36 m apart')}),
    'repeats': Rule(rules_driving.repeats, {
        'tolerance': Parameter('length', 0.1, 'how far the second path may be from the first')}),
    'keeps': Rule(rules_state.keeps, {
        'what': Parameter(tuple(QUANTITIES), ...,
                          'ahead: the distance of stimulus distances; marker ahead, marker left: where the marker is'),
        'value': Parameter('coordinate', ..., 'what it should be'),
        'tolerance': Parameter('length', 0.1, 'how far off it may be'),
        'last': Parameter('time', 5.0, 'how long at the end; the share of that time counts'),
        'swings': Parameter('number', None, 'how often linear.x may change its sign; no points beyond it')}),
    'steers': Rule(rules_state.steers, {
        'command': Parameter(tuple(rules_state.COMMANDS), ..., 'the velocity'),
        'by': Parameter(ANGLES, ..., 'the angle of the marker that stimulus turns shows'),
        'tolerance': Parameter('share', 0.1, 'how far off a velocity may be, as a share of the largest one')}),
    'positions': Rule(rules_driving.positions, {
        'count': Parameter('integer', ..., 'how many'),
        'apart': Parameter('length', 0.5, 'positions closer than this count as one'),
        'by': Parameter((*rules_driving.WAYS, 'driving'), 'teleports',
                        'how it gets there; teleports: by either service')}),
    'pen': Rule(rules_driving.pen, {
        'colour': Parameter('colour', ..., '`[red, green, blue]`, 0 to 255 each'),
        'width': Parameter('span pixels', ANY, 'width of the pen')}),
    'prints': Rule(rules_output.prints, {
        'pattern': Parameter('pattern', ..., 'what has to be found in a line'),
        'times': Parameter('integer', 1, 'in how many lines'),
        'level': Parameter(rules_output.LEVELS, None, 'only lines that were logged with this level'),
        'without': Parameter('pattern', None, 'what such lines must not have, except for two of them'),
        'what': Parameter('text', '', 'what the report calls such a line; the pattern, if empty')}),
    'prints_poses': Rule(rules_output.prints_poses, {
        'fields': Parameter((2, 3), 2, '2: x and y; 3: theta as well'),
        'tolerance': Parameter('length', 0.02, 'how far off a printed value may be'),
        'share': Parameter('share', 0.8, 'how many of the lines with numbers must be right'),
        'lines': Parameter('integer', 20, 'at how many different poses')}),
    'answers': Rule(rules_output.answers, {
        'service': Parameter('name', ..., 'name of the service, which a stimulus calls'),
        'prints': Parameter(('request', 'nothing'), 'nothing', 'request: the numbers of each request must be printed'),
        'tolerance': Parameter('length', 0.01, 'how far off a printed number may be')}),
    'reaches': Rule(rules_output.reaches, {
        'action': Parameter('name', ..., 'name of the action, to which a stimulus sends goals')}),
    'prints_markers': Rule(rules_output.prints_markers, {
        'what': Parameter(('id', 'x'), ..., 'the id, or x of the position'),
        'tolerance': Parameter('length', 0.005, 'how far off x may be')}),
    'prints_no_marker': Rule(rules_output.prints_no_marker, {
        'pattern': Parameter('pattern', r'(?i)\bno(ne)?\b(?!\W*\d)',
                             'how it says so: by default with the word "no" or "none"')}),
    'connects': Rule(rules_output.connects, {
        'topic': Parameter('name', ..., 'name of the topic or service'),
        'role': Parameter(('publishes', 'subscribes', 'serves'), ..., 'what it does with it'),
        'type': Parameter('text', '', 'the name of the type of a topic, in any package; any, if empty')}),
    'parameter': Rule(rules_state.parameter, {
        'name': Parameter('name', ..., 'full name of the parameter'),
        'value': Parameter('value', None, 'a number, a text, true or false')}),
    'background': Rule(rules_state.background, {
        'colour': Parameter('colour', ..., '`[red, green, blue]`, 0 to 255 each')}),
    'transform': Rule(rules_state.transform, {
        'parent': Parameter('text', ..., 'the frame that it starts from'),
        'child': Parameter('text', ..., 'the frame that it leads to'),
        'rate': Parameter('span rate', ANY, 'transforms per second'),
        'at': Parameter(('the vehicle', 'any'), 'any', 'the vehicle: its position and heading are asked'),
        'tolerance': Parameter('length', 0.05, 'how far off that position may be')}),
    'spawns': Rule(rules_state.spawns, {
        'turtle': Parameter('text', ..., 'its name'),
        'x': Parameter('coordinate', ..., 'where it starts'),
        'y': Parameter('coordinate', ..., 'where it starts'),
        'tolerance': Parameter('length', 0.05, 'how far off that it may be')}),
    'follows': Rule(rules_state.follows, {
        'turtle': Parameter('text', ..., 'the name of the turtle that follows turtle1'),
        'distance': Parameter('length', 0.1, 'how near it has to be at the end')}),
    'maps': Rule(rules_navigation.maps, {
        'of': Parameter(('topic', 'file'), 'topic', 'file: the map file that is handed in, and no program runs'),
        'iou': Parameter('share', 0.95, 'of the free area that map and truth have in common, intersection by union'),
        'found': Parameter('share', 0.95, 'how much of the walls has to be found'),
        'right': Parameter('share', 0.95, 'how many of the wall cells have to lie near a wall')}),
    'localises': Rule(rules_navigation.localises, {
        'median': Parameter('length', 0.1, 'half of the time, the error is at most this'),
        'worst': Parameter('length', 0.2, '95 % of the time, the error is at most this'),
        'within': Parameter('time', 15.0, 'the time after the start, and after stimulus carry, that does not count')}),
    'navigates': Rule(rules_navigation.navigates, {
        'goals': Parameter('poses', ..., '`[[x, y, heading], ...]`, such as `[-2 m, 0.5 m, 90 deg]`'),
        'tolerance': Parameter('length', 0.1, 'how far from the pose it may be'),
        'turn': Parameter('angle', 0.1, 'how far off the heading may be'),
        'rest': Parameter('time or 0', 0.5, 'how long it has to stand there'),
        'detour': Parameter('number', None, 'how many times longer than the shortest path a drive may be')}),
    'runs': Rule(rules_output.runs, {
        'until': Parameter(('the end', 'it is done'), 'the end',
                           'the end: it must not end by itself; it is done: it ends with exit code 0')}),
}


def judge(name: str, observed: Observed, parameters: Mapping[str, Any]) -> Result:
    """Return the Result of the rule ``name`` with {parameter: value}, all of them."""
    return RULES[name].judge(observed, SimpleNamespace(**parameters))
