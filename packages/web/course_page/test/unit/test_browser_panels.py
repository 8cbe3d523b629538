"""The logic of the page's panels, which is JavaScript: it runs in a browser, with values from tables."""
import functools
import http.server
import json
import math
import pathlib
import re
import threading

import pytest

from plain_support import course
from rostest_support import browser
from unit_support import REPOSITORY

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)]
CASES = pathlib.Path(__file__).with_name('cases.js')
COURSE = course.steps(REPOSITORY / 'course')
POSE = {'type': 'turtlesim/Pose', 'fieldnames': ['x', 'y'], 'fieldtypes': ['float32', 'float32'],
        'fieldarraylen': [-1, -1]}
SCAN = {'type': 'a/Scan', 'fieldnames': ['header', 'ranges', 'name', 'pose'], 'fieldarraylen': [-1, 0, -1, -1],
        'fieldtypes': ['std_msgs/Header', 'float32', 'string', 'turtlesim/Pose']}
HEADER = {'type': 'std_msgs/Header', 'fieldnames': ['seq', 'stamp'], 'fieldtypes': ['uint32', 'time'],
          'fieldarraylen': [-1, -1]}
PICTURES = [{'name': name, 'type': 'sensor_msgs/Image'} for name in (
    '/camera/aligned_depth/image_raw', '/turtlesim/image_raw', '/camera/color/image_raw')]
GRADED = {'result': {'outcome': 'failed', 'score': 20.04, 'objections': ['it teleports'], 'hints': ['look at x'],
                     'notes': ['chmod'], 'seconds': 3.46, 'isolation': 'namespace',
                     'reasons': [{'points': 20.0, 'of': 20, 'asked': 'move', 'seen': 'moved'}]}}
TYPES = f'new (await import("/panels/lib/types.js")).Types({json.dumps([SCAN, HEADER, POSE])})'


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture(scope='module')
def page():
    handler = functools.partial(Quiet, directory=str(REPOSITORY / 'packages' / 'web' / 'course_page' / 'web'))
    with http.server.ThreadingHTTPServer(('localhost', 0), handler) as server, browser.Browser() as opened:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        opened.get(f'http://localhost:{server.server_port}/README.md')
        yield opened
        server.shutdown()


def value(page, module, expression):
    """Return the value of an expression with the names of a module, or the text of its error."""
    return json.loads(page.evaluate(f'''(async () => {{
        try {{
            const m = await import("/panels/lib/{module}.js");
            return JSON.stringify({expression}) ?? "null";
        }} catch (error) {{ return JSON.stringify(`error: ${{error.message}}`); }}
    }})()'''))


@pytest.mark.parametrize('module, expression, expected', [
    ('form', 'm.parse("0.5", "float64")', 0.5),
    ('form', 'm.parse("1e-3", "float32")', 0.001),
    ('form', 'm.parse(" -inf ", "float64")', '-Infinity'),
    ('form', 'm.parse("1,5", "float64")', 'error: "1,5" is not a number. Use a point, not a comma: 0.5'),
    ('form', 'm.parse("1e999", "float64")', 'error: 1e999 is too large for a float64.'),
    ('form', 'm.parse("256", "uint8")', 'error: 256 is not allowed: a uint8 is from 0 to 255.'),
    ('form', 'm.parse("-128", "int8")', -128),
    ('form', 'm.parse("3.0", "int32")', 'error: "3.0" is not a whole number. Example: 3'),
    ('form', 'm.parse("TRUE", "bool")', True),
    ('form', 'm.parse("  a ", "string")', '  a '),
    ('form', 'm.parseArray("[1, 2 3;4]", "uint8", 0)', [1, 2, 3, 4]),
    ('form', 'm.parseArray("", "float64", 0)', []),
    ('form', 'm.parseArray("1, 2", "float64", 3)', 'error: 2 values; this array has exactly 3.'),
    ('form', 'm.parseArray("1, x", "float64", 0)',
     'error: Value 2: "x" is not a number. Examples: 0.5, -2, 1e-3, inf, nan'),
    ('form', '''m.parseArray('["a, b", "c"]', "string", 0)''', ['a, b', 'c']),
    ('fields', 'm.expand("/turtle1/pose/x:y, odom/a//b/")',
     ['/turtle1/pose/x', '/turtle1/pose/y', '/odom/a/b']),
    ('fields', 'm.split("/a/b/c", ["/a", "/a/b", "/a/bc"])', {'topic': '/a/b', 'path': 'c'}),
    ('fields', 'm.split("/a", ["/b"])', None),
    ('navigation_map', '[...new Uint8Array(m.mapColours().buffer)].slice(4 * 100, 4 * 101)', [0, 0, 0, 255]),
    ('navigation_map', '[...new Uint8Array(m.mapColours().buffer)].slice(4 * 255)', [112, 137, 134, 255]),
    ('navigation_map', '[0, 99, 100, 255].map((value) => m.costColours()[value] >>> 24)', [0, 150, 200, 0]),
    ('../console', '''(() => {
        const log = (secs, msg) => ({header: {stamp: {secs, nsecs: 0}}, name: "/a", msg});
        return m.merged([log(1, "old"), log(2, "both")], [log(2, "both"), log(2, "new")]).map((one) => one.msg);
     })()''', ['old', 'both', 'new']),
    # axes of a gamepad: right and down are positive, and a tenth around the middle counts as the middle
    ('../../app/drive', 'm.gamepadInput({axes: [1, -1, 0, 0], buttons: []}, false)', {'x': 1, 'y': 0, 'turn': -1}),
    ('../../app/drive', 'm.gamepadInput({axes: [-1, 0, 1, 0], buttons: []}, true)', {'x': 0, 'y': 1, 'turn': -1}),
    ('../../app/drive', 'm.gamepadInput({axes: [0.09, -0.05], buttons: []}, true)', None),
    ('../../app/drive', 'm.gamepadInput({axes: [1, 1], buttons: [{}, {pressed: true}]}, true)', None),
    ('rows', '["/rosout", "/turtle1/pose", "/camera/color/image_raw", "bare"].map(m.namespaceOf)',
     ['/', '/turtle1', '/camera', '/']),
    ('../../app/address', 'm.besideOf("turtle", {beside: "plot,turtle,,graph,plot,map,image"})',
     ['plot', 'graph', 'map']),
    ('../../app/address', 'm.besideOf("turtle", {})', []),
    ('../../app/address',
     '["", "plot"].map((id) => m.ownParameters({a: "1", beside: "plot", "plot.fields": "/x"}, id))',
     [{'a': '1'}, {'fields': '/x'}]),
    ('../../app/address',
     'm.besideParameters({a: "1", "plot.fields": "/x", "graph.filter": "y", beside: "plot,graph"}, ["plot"])',
     {'plot.fields': '/x', 'beside': 'plot'}),
    ('../../app/address',
     'm.parseAddress(m.addressOf("turtle", {beside: "plot,graph", "plot.fields": "/a/x,/a/y", b: ""}))',
     {'id': 'turtle', 'parameters': {'beside': 'plot,graph', 'plot.fields': '/a/x,/a/y'}}),
    ('../../app/address', 'm.withoutToken("http://localhost:8000/?token=a-b&x=1#/plot?fields=/a/x")',
     'http://localhost:8000/?x=1#/plot?fields=/a/x'),
    ('../../app/address', 'm.withoutToken("https://class.example/turtle/?token=a#/")', 'https://class.example/turtle/#/'),
    ('../../app/shell',
     """[{"mine": "#/plot?a=1", "bad": "javascript:alert(1)", "worse": 5}, null, [], 5, "x"].map(m.savedLayouts)""",
     [{'mine': '#/plot?a=1'}, {}, {}, {}, {}]),
    ('../../app/dom', '(m.store("a", [1]), localStorage.setItem("b", "["), ["a", "b", "c"].map(m.stored))',
     [[1], None, None]),
    ('../grade', 'm.verdictOf({result: null})',
     {'text': 'no verdict', 'kind': 'bad', 'hints': [], 'checks': [], 'notes': []}),
    ('../grade', f'm.verdictOf({json.dumps(GRADED)})',
     {'text': 'failed, 20 of 100', 'kind': 'bad', 'hints': ['it teleports', 'Hint: look at x'],
      'checks': [{'points': '20', 'of': '20', 'asked': 'move', 'seen': 'moved'}],
      'notes': ['chmod', 'Graded 3.5 s of simulated time; isolation of the program: namespace.']}),
    ('../grade', f'm.verdictOf({{result: {{...{json.dumps(GRADED["result"])}, certain: true}}}}).hints',
     ['it teleports', 'Mistake: look at x']),
    ('../grade', f'm.verdictOf({{result: {{...{json.dumps(GRADED["result"])}, outcome: "undecided"}}}}).text',
     'undecided'),
    ('../grade', 'm.shortPath("/w/src/a/b.py", ["/w/src"])', 'b.py (a)'),
    ('../grade', 'm.shortPath("/w/b.py", ["/w"])', 'b.py'),
    ('../grade', 'm.shortPath("/w/src/a/b.py", ["/w", "/w/src", "/h"])', 'b.py (src/a)'),
    ('../graph', 'm.largest([{width: 400, height: 100}, null, {width: 200, height: 200}], 400, 300).width', 200),
    ('../graph', 'm.largest([{width: 400, height: 100}, {width: 200, height: 200}], 400, 100).width', 400),
    ('../graph', 'm.largest([null, null], 400, 100)', None),
    ('../../app/ros', 'm.addressFor("http://localhost:8000/?token=a/b#/plot?fields=/a/x")', 'ws://localhost:8000/'),
    ('../../app/ros', 'm.addressFor("https://class.example/hub/turtle/index.html#/")', 'wss://class.example/hub/turtle/'),
    ('../../app/video', '["/", "/index.html", "/turtle/", "/user/ann/proxy/8000/"].map(m.isStreamed)',
     [True, True, False, False]),
    ('../image', f'm.bestPicture({json.dumps(PICTURES)})', '/camera/color/image_raw'),
    ('../image', f'm.bestPicture({json.dumps(PICTURES[:2])})', '/turtlesim/image_raw'),
    ('../image', f'm.bestPicture({json.dumps(PICTURES[:1])})', '/camera/aligned_depth/image_raw'),
    ('../image', 'm.bestPicture([])', None),
    ('fields', f'm.numbersAt({TYPES}, "pose")', ['pose/x', 'pose/y']),
    ('fields', f'm.numbersAt({TYPES}, "ranges[7]")', ['ranges[7]']),
    ('fields', f'm.numbersAt({TYPES}, "header/stamp")', ['header/stamp']),
    ('fields', f'm.numbersAt({TYPES}, "name")', 'error: a/Scan has no number "name". It has header/seq, header/stamp, '
     'ranges[0], pose/x, pose/y.'),
    # seq 4 + stamp 8, length 4 + 2 * 4, length 4 + 2 (u umlaut), 2 * 4 bytes
    ('values', f'm.sizeOf({{header: {{seq: 1, stamp: {{secs: 0, nsecs: 0}}}}, ranges: [1, null], name: "\\u00fc", '
     f'pose: {{x: 0, y: 0}}}}, "a/Scan", null, {TYPES})', 38),
    ('values', r'm.clean("a\nb\u202e<b>", 5)', 'a\\nb\\u202e<…'),
    ('values', 'm.short(null, "float32")', 'NaN or infinite'),
    ('values', 'm.short([1, 2, 3, 4, 5, 6, 7, 8, 9.5], "float64", true)', '[1, 2, 3, 4, 5, 6, 7, 8, …] 9 elements'),
    ('values', 'm.short("AAAA", "uint8", true)', '3 bytes'),
    ('values', 'm.short(5.544444561004639, "float32")', '5.544445'),
    ('values', 'm.at({a: [{b: 2}]}, ["a", 0, "b"])', 2),
    ('values', 'm.at({}, ["constructor"]) === undefined', True),
    ('samples', 'm.merge([[[1, 3], [10, 30]], [[2, 3], [5, 6]]])', [[1, 2, 3], [10, None, 30], [None, 5, 6]]),
    ('samples', 'm.toCsv(["/a", "b\\"c"], [[1, 2], [0.5, null], [3, 4]])',
     '"time","/a","b""c"\n1.0000,0.5,3\n2.0000,,4\n'),
    ('samples', 'm.summary([0, 1, 2, 3], [9, 1, null, 4], 1, 3)', {'last': 4, 'min': 1, 'max': 4}),
    ('../parameters',
     '["1", "1.0", "true", "[1, 2]", "a b", "\\"1\\"", "[1"].map((text) => m.parseValue(text).kind)',
     ['int', 'double', 'bool', 'list', 'text', 'text', '']),
    ('../parameters', '[1, "1", "a", true, [1], {a: "b"}].map(m.valueText)',
     ['1', '"1"', 'a', 'true', '[1]', '{"a":"b"}']),
    ('../parameters', 'm.flatten({b: {c: 1, d: {}}, a: [1]})', [['/a', [1]], ['/b/c', 1], ['/b/d', {}]]),
    ('parts', '''m.asArgument({x: 1, name: "it's", list: [true, "NaN"]})''',
     """'{x: 1, name: "it'\\''s", list: [true, .nan]}'"""),
])
def test_values(page, module, expression, expected):
    assert value(page, module, expression) == expected


def test_rows_are_listed_by_namespaces(page):
    assert page.call(CASES, 'cases.namespaces') == [
        [1, 0], [True, False], [True, False], [True, True], ['/ (1)', '/b (2)']]


@pytest.mark.parametrize('messages, now, trees, rows', [
    ([], 0, 0, []),
    ([(0, True, [('base', 'laser')]), (1, False, [('/odom', '/base')])], 2, 1,
     [['odom', 0, ''], ['base', 1, ''], ['laser', 2, '']]),
    ([(0, False, [('odom', 'base')])], 9, 1, [['odom', 0, ''], ['base', 1, 'nothing has come for 9 s']]),
    ([(0, True, [('base', 'laser')])], 99, 1, [['base', 0, ''], ['laser', 1, '']]),
    ([(0, False, [('map', 'base'), ('odom', 'base')])], 0, 1,
     [['odom', 0, ''], ['base', 1, 'two nodes disagree about its parent: also map']]),
    ([(0, False, [('a', 'b'), ('c', 'd')])], 0, 2, [['a', 0, ''], ['b', 1, ''], ['c', 0, ''], ['d', 1, '']]),
    ([(0, False, [('a', 'b'), ('b', 'a')])], 0, 0,
     [['b', 0, 'it is its own ancestor: the frames below form a circle'], ['a', 1, '']]),
], ids=['nothing', 'tree', 'lost', 'static', 'two parents', 'two trees', 'circle'])
def test_frames_form_a_tree_and_faults_are_named(page, messages, now, trees, rows):
    assert page.call(CASES, 'cases.frameTree', messages, now) == {'trees': trees, 'rows': rows}


def test_rates_and_angles_of_frames(page):
    assert value(page, '../frames', 'm.rateOf({times: [0, 0.5, 1]})') == 2
    assert value(page, '../frames', 'm.rateOf({times: [3]})') == 0
    # a quarter turn about z, then one about y with a value that rounding has pushed beyond 1
    assert value(page, '../frames', 'm.rollPitchYaw({x: 0, y: 0, z: 0.6, w: 0.8})') == pytest.approx([0, 0, 1.2870022])
    assert value(page, '../frames', 'm.rollPitchYaw({x: 0, y: 0.7071068, z: 0, w: 0.7071069})')[1] == \
        pytest.approx(1.5707963)


EDIT = str({'enum': [{'name': 'Small', 'type': 'int', 'value': 0, 'description': "it's"},
                     {'name': 'Large', 'type': 'int', 'value': 7, 'description': ''}], 'enum_description': 'sizes'})
DESCRIPTION = json.dumps({
    'groups': [{'parameters': [{'name': 'size', 'type': 'int', 'description': 'how large', 'edit_method': EDIT}]},
               {'parameters': [{'name': 'acc', 'type': 'double', 'description': '', 'edit_method': ''},
                               {'name': 'odd', 'type': 'matrix', 'description': '', 'edit_method': ''}]}],
    **{key: {'bools': [], 'ints': [{'name': 'size', 'value': whole}], 'strs': [],
             'doubles': [{'name': 'acc', 'value': number}]}
       for key, whole, number in (('min', 0, 0.5), ('max', 7, 2.5), ('dflt', 7, 1.5))}})


def test_parameters_of_dynamic_reconfigure_are_described(page):
    size, acc = value(page, '../reconfigure', f'm.parametersOf({DESCRIPTION})')
    assert size == {'name': 'size', 'type': 'int', 'text': 'how large', 'min': 0, 'max': 7, 'usual': 7,
                    'choices': [['0', 'Small'], ['7', 'Large']]}
    assert (acc['name'], acc['min'], acc['max'], acc['usual'], acc['choices']) == ('acc', 0.5, 2.5, 1.5, [])
    assert value(page, '../reconfigure', 'm.changeOf({name: "acc", type: "double"}, 2)') == {
        'bools': [], 'ints': [], 'strs': [], 'doubles': [{'name': 'acc', 'value': 2}], 'groups': []}


@pytest.mark.parametrize('kind, text, expected', [
    ('double', '2.5', 2.5), ('double', '2.6', 'error: acc is 2.6; it must be from 0.5 to 2.5.'),
    ('double', '', 'error: acc is ""; it must be a number.'),
    ('int', '1.5', 'error: acc is "1.5"; it must be a whole number.'), ('str', ' a', ' a'), ('bool', 'true', True)])
def test_a_typed_value_is_checked(page, kind, text, expected):
    assert value(page, '../reconfigure', 'm.parseFor({name: "acc", type: "double", min: null, max: null}, "-3")') == -3
    call = f'm.parseFor({{name: "acc", type: "{kind}", min: 0.5, max: 2.5}}, {json.dumps(text)})'
    assert value(page, '../reconfigure', call) == expected


def test_rates_are_those_of_the_messages(page):
    assert value(page, '../topics', '''(() => {
        const meter = new m.Meter();
        for (let i = 0; i < 100; i += 1) meter.add(i / 50, 20);
        return [meter.read(1.98), meter.read(60)];
    })()''') == [{'rate': pytest.approx(50), 'bandwidth': pytest.approx(1000)}, {'rate': 0, 'bandwidth': 0}]


def test_samples_are_bounded(page):
    """70 s at 1000 Hz: at most the 15750 newest of the last 63 s stay."""
    count, first = value(page, 'samples', '''(() => {
        const samples = new m.Samples();
        samples.add('x');
        for (let i = 0; i < 70000; i += 1) samples.take({x: i}, i / 1000);
        return [samples.values('x').length, samples.values('x')[0]];
    })()''')
    assert 15000 <= count <= 15750
    assert first == 70000 - count


def test_log_is_bounded_and_counts_repeated_messages(page):
    size, dropped, times = value(page, '../console', '''(() => {
        const log = new m.Log(100);
        const message = (i) => ({level: 2, name: '/n', msg: `${i}`, header: {stamp: {secs: 1, nsecs: 0}}, file: '',
                                 line: 1, function: ''});
        for (let i = 0; i < 1000; i += 1) log.add(message(i));
        for (let i = 0; i < 50; i += 1) log.add(message('again'));
        return [log.size, log.dropped, log.find({levels: new Set([2]), node: '', text: 'again'})[0].count];
    })()''')
    assert size <= 110
    assert size + dropped == 1001
    assert times == 50


def test_a_graph_of_50_nodes_is_laid_out_without_overlaps(page):
    boxes = page.call(CASES, 'cases.graph', 50)
    assert len(boxes) == 100
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            assert (abs(one['x'] - other['x']) >= (one['width'] + other['width']) / 2 - 1
                    or abs(one['y'] - other['y']) >= (one['height'] + other['height']) / 2 - 1)


@pytest.mark.parametrize('step', COURSE, ids=lambda step: step.folder.name)
def test_every_command_of_a_page_is_read(page, step):
    text = step.page.read_text(encoding='utf-8')
    commands = [command['text'] for block in value(page, '../course', f'm.parseStep({json.dumps(text)})')
                if block['kind'] == 'commands' for command in block['commands']]
    blocks = re.findall(r'```bash\n(.*?)```', text, re.DOTALL)
    assert len(commands) == len([line for block in blocks for line in block.splitlines() if line.strip()])
    assert not [command for command in commands if '# terminal' in command]


def test_rules_are_those_of_steps_and_panels_exist(page):
    assert set(value(page, 'course_rules', 'm.RULES')) <= {step.number for step in COURSE}
    shown = {panel for step in COURSE for panel in step.panels}
    assert shown <= {path.stem for path in (REPOSITORY / 'packages/web/course_page/web/panels').glob('*.js')}


def node(*publishing, reads=(), serves=()):
    return {'publishing': publishing, 'subscribing': reads, 'services': serves}


TYPES_OF_TOPICS = {'/turtle1/pose': 'turtlesim/Pose', '/turtle1/cmd_vel': 'geometry_msgs/Twist',
                   '/odom': 'nav_msgs/Odometry', '/cmd_vel': 'geometry_msgs/Twist',
                   '/ar_pose_marker': 'ar_track_alvar_msgs/AlvarMarkers'}
SIMULATORS = {'/turtlesim': node('/turtle1/pose', reads=['/turtle1/cmd_vel']),
              '/robotont_gazebo': node('/odom', reads=['/cmd_vel']), '/ar_track_alvar': node('/ar_pose_marker')}
PUBLISHER, READER = node('/turtle1/cmd_vel'), node(reads=['/turtle1/pose'])
STEERING = node('/turtle1/cmd_vel', reads=['/turtle1/pose'])
ROBOT_STEERING = node('/cmd_vel', reads=['/odom'])
TO_TEN = [(6 + 0.5 * step, 5.5, 1.0) for step in range(9)] + [(10.0, 5.5, 0.0)]
SQUARE = [(x, y, 1.0) for x, y in ((5, 5), (5.5, 5), (6, 5), (6, 5.5), (6, 6), (5.5, 6), (5, 6), (5, 5.5), (5, 5.02))]
JUMPS = [(1 + 4 * (step % 2), 1 + 2 * step, 0.0) for step in range(5)]


@pytest.mark.parametrize('program, drives, steps', [
    (('/velocity_publisher', PUBLISHER), [], [1]),
    (('/mine', PUBLISHER), [], [1]),
    (('/velocity_publisher_1234_5678', PUBLISHER), [], [1]),  # anonymous
    (('/teleop_turtle', PUBLISHER), [], [1]),
    (('/browser', STEERING), TO_TEN + SQUARE, []),  # the page itself
    (('/reader', READER), [], [2]),
    (('/stop_at_x', STEERING), TO_TEN, [1, 2, 3]),
    (('/stop_at_x', STEERING), TO_TEN[:-1], [1, 2]),  # it has not stopped
    (('/stop_at_x', STEERING), TO_TEN[-2:], [1, 2]),  # it was put there
    (('/teleop_turtle', PUBLISHER), TO_TEN, [1]),  # driven with the keyboard
    (('/drive_shape', STEERING), SQUARE, [1, 2, 4]),
    (('/drive_shape', STEERING), SQUARE[:-2], [1, 2]),  # not back yet
    (('/drive_shape', STEERING), SQUARE[:2] * 9, [1, 2]),  # to and fro
    (('/velocity_publisher', PUBLISHER), SQUARE, [1]),  # in a circle, without looking at the pose
    (('/goto_pose_server', node(serves=['/turtle1/gotoPose'])), [], [6]),
    (('/tour', READER), JUMPS, [2, 7]),
    (('/tour', READER), JUMPS[:4], [2]),
    (('/tracker_reader', node(reads=['/ar_pose_marker'])), [], [8]),
    (('/robot', node('/cmd_vel')), [(0.05 * step, 0, 0.5) for step in range(4)], [9]),
    (('/robot', node('/cmd_vel')), [(0, 0, 0.0)] * 4, []),  # it stands
    (('/robot', ROBOT_STEERING), SQUARE, [9, 10]),
    (('/robot', ROBOT_STEERING), SQUARE[:-2], [9]),
    (('/follower', node('/cmd_vel', reads=['/ar_pose_marker'])), [], [8, 11]),
])
def test_a_step_of_the_course_is_seen(page, program, drives, steps):
    """A program beside the simulators, and what its vehicle does: (x, y [m], speed [m/s]) each second."""
    robot = '/cmd_vel' in program[1]['publishing']
    assert watched(page, {**SIMULATORS, program[0]: program[1]}, TYPES_OF_TOPICS, drives, robot) == steps


def test_a_second_turtle_is_seen(page):
    assert watched(page, SIMULATORS, {**TYPES_OF_TOPICS, '/leo/pose': 'turtlesim/Pose'}) == [5]


def watched(page, nodes, types, drives=(), robot=False):
    """Return the steps that are marked done."""
    return value(page, 'course_rules', f'''(() => {{
        const done = new Set();
        const watcher = new m.Watcher((number) => done.add(number));
        const map = (values) => new Map(Object.entries(values));
        watcher.update({{nodes: map({json.dumps(nodes)}), types: map({json.dumps(types)})}});
        for (const [index, [x, y, speed]] of {json.dumps(drives)}.entries()) {{
            const twist = {{twist: {{linear: {{x: speed, y: 0}}}}}};
            const odometry = {{pose: {{pose: {{position: {{x, y}}}}}}, twist}};
            if ({json.dumps(robot)}) watcher.pose("/odom", "nav_msgs/Odometry", odometry, index);
            else watcher.pose("/turtle1/pose", "turtlesim/Pose", {{x, y, linear_velocity: speed}}, index);
        }}
        return [...done].sort((a, b) => a - b);
    }})()''')


@pytest.mark.parametrize('nodes, pages, text', [
    ([], 0, ''), ([], -1, ''), ([], 1, 'Another page drives now.'), ([], 3, '3 other pages drive now.'),
    (['/teleop'], 0, '/teleop publishes on /cmd_vel, too.'),
    (['/a', '/b'], 1, '/a, /b publish on /cmd_vel, too. Another page drives now.'),
])
def test_who_else_drives_is_said(page, nodes, pages, text):
    assert value(page, '../../app/drive', f'm.othersText("/cmd_vel", {json.dumps(nodes)}, {pages})') == text


def test_a_silent_link_counts_as_stalled_until_something_comes(page):
    before, time, after = page.call(CASES, 'cases.silence')
    assert (before, after) == (False, False)
    assert 1000.0 < time < 5000.0  # [ms]; 2000 after the last answer


def test_a_message_does_not_cover_the_picture_on_a_phone_held_sideways(page):
    address = page.driver.current_url
    page.resize(844, 390, touch=True)
    page.get(address.replace('README.md', 'index.html'))
    try:
        assert page.call(CASES, 'cases.toast') < 10.0  # [px] below the bar, where the heading of the panel is
    finally:
        page.resize(1280, 800)
        page.get(address)


def test_frames_are_joined_in_the_plane(page):
    """The robot is 2 m along odom's x axis, which is map's y axis, and looks there; the laser is 1 m to its left."""
    laser, of_map, unknown = page.call(
        CASES, 'cases.poses',
        [('map', 'odom', 1, 0, math.pi / 2), ('/odom', 'base', 2, 0, 0), ('base', 'laser', 0, 1, 0)],
        [('laser', 'map'), ('map', '/base'), ('base', 'nowhere')])
    assert [laser[key] for key in ('x', 'y', 'yaw')] == pytest.approx([0.0, 2.0, 1.5707963])
    assert [of_map[key] for key in ('x', 'y', 'yaw')] == pytest.approx([-2.0, 1.0, -1.5707963])
    assert unknown is None
