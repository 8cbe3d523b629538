"""rospy_support.parameters: accepted values, refused values, and errors of each kind. Without a master."""
import math
import socket

import pytest
import rospy

from rospy_support import parameters
from rospy_support.parameters import Boolean, Computed, Integer, Number, Numbers, Table, Text

NODE = '/sim/node'
HUGE = 2 ** 31 - 1  # the largest whole number that the parameter server carries


@pytest.fixture
def server(monkeypatch):
    """The parameter server: resolved name -> value."""
    values = {}

    def resolve_name(name):
        return f'{NODE}/{name[1:]}' if name.startswith('~') else name if name.startswith('/') else f'/sim/{name}'
    monkeypatch.setattr(rospy, 'resolve_name', resolve_name)
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: values.get(resolve_name(name), default))
    monkeypatch.setattr(parameters, '_effective', {})
    return values


def refusal(kind, *args, **kwds):
    with pytest.raises(parameters.ParameterError) as error:
        kind(*args, **kwds).read()
    return str(error.value)


LIMITS = {'minimum': 0.5, 'maximum': 20}
TAKEN = [  # parameter, values that are set, values that are read
    (Number('~a', 1.0), [10.0, 3, 0, -1e300, HUGE], [10.0, 3.0, 0.0, -1e300, float(HUGE)]),
    (Number('~a', 1.0, **LIMITS), [0.5, 20, 19.999], [0.5, 20.0, 19.999]),
    (Number('~a', 1.0, maximum=0.0), [-5], [-5.0]), (Number('~a', 1.0, minimum=0.0), [5], [5.0]),
    (Integer('~a', 7, 0, 255), [3, 0, 255, 3.0, 0.0, 255.0], [3, 0, 255, 3, 0, 255]),
    (Integer('~a', 7), [-7, HUGE, -HUGE], [-7, HUGE, -HUGE]),
    (Boolean('~a', False), [True, False], [True, False]), (Boolean('~a', True), [True, False], [True, False]),
    (Text('~a', 'square', choices=('square', 'circle')), ['circle'], ['circle']),
    (Text('~a', 'square'), ['anything', '', 'ä b'], ['anything', '', 'ä b']),
    (Numbers('~a', [9.0]), [[1, 2.5, -3], [], [[4, 4], (7, 4), [[1]]]],
     [[1.0, 2.5, -3.0], [], [[4.0, 4.0], [7.0, 4.0], [[1.0]]]]),
    (Numbers('~a', [9.0], 2), [(1, 2), [[1, 2], [3, 4.5]]], [[1.0, 2.0], [[1.0, 2.0], [3.0, 4.5]]]),
]
NO_NUMBERS = True, False, '10', '', math.nan, math.inf, -math.inf, None, [], [1.0], {'a': 1}
REFUSED = [  # parameter, values, what is allowed, the default as one types it
    (Number('~a', 10.0, unit='Hz', **LIMITS), [*NO_NUMBERS, 0.49, 20.01, -3, HUGE], 'a number from 0.5 to 20 Hz',
     '10.0'),
    (Number('~a', 1.0, clamp=True, **LIMITS), [math.nan, math.inf, 'fast', True], 'a number from 0.5 to 20', '1.0'),
    (Number('~a', 0.0), ['much'], 'a number', '0.0'),
    (Number('~a', 0.0, 0.1), ['much'], 'a number of at least 0.1', '0.0'),
    (Number('~a', 0.0, maximum=1e6), ['much'], 'a number of at most 1e+06', '0.0'),
    (Number('~a', 0.0, -1, 1, unit='m/s'), ['much'], 'a number from -1 to 1 m/s', '0.0'),
    (Number('~a', 0.0, unit='s'), ['much'], 'a number s', '0.0'),
    (Integer('~a', 3, 0, 255, unit='px'), [*NO_NUMBERS, -1, 256, -1.0, 256.0, 2.5, 1e300],
     'a whole number from 0 to 255 px', '3'),
    (Boolean('~a', False), [0, 1, 1.0, 'true', 'false', '', None, []], 'true or false', 'false'),
    (Text('~a', 'square', choices=('square', 'circle')), ['Circle', '', 'square, circle', 5], 'one of square, circle',
     'square'),
    (Text('~a', 'square'), [5, True, None, ['a'], 2.5], 'a text', 'square'),
    (Text('~a', 'odom', filled=True), ['', 5, None], 'a text that is not empty', 'odom'),
    (Numbers('~a', [1.0], unit='m'), [5, 5.0, '1, 2', '[1, 2]', True, None, {'a': 1}, [True], ['1'], [math.nan],
                                      [math.inf], [1.0, -math.inf], [None], [[1.0, 'x']], [[math.nan]], [{}]],
     'a list of finite numbers m', '"[1.0]"'),
    (Numbers('~a', [1, 2, 3], length=3), [[], [1, 2], [1, 2, 3, 4]], 'a list of 3 numbers', '"[1, 2, 3]"'),
]


@pytest.mark.parametrize('parameter, values, expected', TAKEN)
def test_values_that_are_taken(server, parameter, values, expected):
    for value, read in zip(values, expected):
        server[f'{NODE}/a'] = value
        assert repr(parameter.read()) == repr(read)  # which has the type


@pytest.mark.parametrize('parameter, values, allowed, default', REFUSED)
def test_values_that_are_refused(server, parameter, values, allowed, default):
    for value in values:
        server[f'{NODE}/a'] = value
        with pytest.raises(parameters.ParameterError) as error:
            parameter.read()
        assert str(error.value) == (
            f'parameter /sim/node/a is {value!r}; it must be {allowed}. Set it with _a:={default} on the command line '
            f'or rosparam set /sim/node/a {default}')


@pytest.mark.parametrize('value, expected', [(60, 20.0), (0.1, 0.5), (-3, 0.5), (7, 7.0)])
def test_number_that_clamps_takes_the_nearest_allowed_and_says_so(server, logged, value, expected):
    server[f'{NODE}/rate'] = value
    assert Number('~rate', 1.0, unit='Hz', clamp=True, **LIMITS).read() == expected
    assert logged == ([] if value == expected else [
        f'parameter /sim/node/rate is {value}; it must be from 0.5 to 20 Hz; using {expected:g}'])
    assert parameters._effective == {f'{NODE}/rate': f'{expected} Hz'}


@pytest.mark.parametrize('default', ['', None])
def test_refusal_without_an_example_to_show_says_what_to_type_in_words(server, default):
    server['/sim/node/path'] = 5
    assert '_path:=TEXT on the command line' in refusal(Text, '~path', default)


@pytest.mark.parametrize('parameter, expected', [
    (Number('~a', 2), 2.0), (Integer('~a', 2), 2), (Boolean('~a', True), True), (Text('~a', 'b', ('b', 'c')), 'b'),
    (Numbers('~a', (1, 2)), [1.0, 2.0]),
])
def test_parameter_that_is_not_set_has_its_default(server, parameter, expected):
    assert repr(parameter.read()) == repr(expected)


@pytest.mark.parametrize('name, resolved', [('~a/b', '/sim/node/a/b'), ('/global', '/global'),
                                            ('relative', '/sim/relative')])
def test_refusal_names_the_resolved_parameter(server, name, resolved):
    server[resolved] = 'bad'
    text = refusal(Number, name, 1.0)
    assert text.startswith(f'parameter {resolved} is ')
    assert text.endswith(f'rosparam set {resolved} 1.0')


def test_effective_values_are_logged_in_one_line_with_units_in_the_order_of_reading(server, logged):
    server.update({f'{NODE}/rate': 5, f'{NODE}/corners': [1, 2], f'{NODE}/bad': 'x'})
    Number('~rate', 10.0, unit='Hz').read()
    Text('~shape', 'square').read()
    Numbers('~corners', [], unit='m').read()
    Integer('~width', 3, unit='px').read()
    refusal(Number, '~bad', 1.0)
    Boolean('~window', False).read()
    parameters.log_effective()
    assert logged == ['Parameters: /sim/node/rate=5.0 Hz, /sim/node/shape=square, /sim/node/corners=[1.0, 2.0] m, '
                     '/sim/node/width=3 px, /sim/node/window=False']


def test_secret_is_in_no_log_and_no_error(server, logged):
    server.update({f'{NODE}/token': 'swordfish', f'{NODE}/other': ['swordfish']})
    assert Text('~token', '', secret=True).read() == 'swordfish'
    assert 'swordfish' not in refusal(Text, '~other', '', secret=True)
    parameters.log_effective()
    assert logged == ['Parameters: /sim/node/token=(hidden)']


def test_refusal_of_a_public_parameter_suggests_no_private_one(server):
    server['/sim/scale'] = 'fast'
    text = refusal(Number, 'scale', 2.0)
    assert ':=' not in text and 'rosparam set' in text


@pytest.mark.parametrize('error', [ConnectionRefusedError('refused'), socket.timeout('timed out')])
def test_a_master_that_does_not_answer_is_told(monkeypatch, error):
    def get_param(*_):
        raise error
    monkeypatch.setattr(rospy, 'get_param', get_param)
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', '/sim/node/'))
    with pytest.raises(parameters.MasterAway, match=f'/sim/node/rate cannot be read.*{error}.*roscore'):
        Number('~rate', 1.0).read()


SHARED = Table(Boolean('~strafe', False))
TABLE = Table(Number('~rate', 10.0), SHARED, Text('~folder', Computed('the working directory')))


def test_table_reads_its_own_and_shared_parameters_in_the_order_that_is_asked_for(server):
    assert [parameter.name for parameter in TABLE] == ['~rate', '~strafe', '~folder']
    server[f'{NODE}/rate'] = 5.0
    assert TABLE.read('~strafe', '~rate') == [False, 5.0]
    assert SHARED.read() == [False]


def test_table_has_each_name_once():
    with pytest.raises(ValueError, match='~strafe is declared twice'):
        Table(SHARED, Boolean('~strafe', True))


def test_default_that_is_computed_has_to_be_given(server):
    with pytest.raises(TypeError, match='default of ~folder, the working directory, has to be given'):
        TABLE.read('~folder')
    assert TABLE['~folder'].read('/tmp') == '/tmp'


def test_values_that_were_read_before_take_the_place_of_the_server(server):
    server[f'{NODE}/width'] = 7
    assert Integer('~width', 3).read(values={f'{NODE}/width': 5}) == 5
    assert Integer('~width', 3).read(values={}) == 3


def test_node_reads_only_what_it_declares(server, monkeypatch):
    monkeypatch.setattr(parameters, '_declared', None)
    parameters.declare(TABLE)
    assert TABLE['~rate'].read() == 10.0
    with pytest.raises(LookupError, match='~speed is not in the table'):
        Number('~speed', 1.0).read()


@pytest.mark.parametrize('parameter, text', [
    (Number('~a', 1.0), 'finite'), (Number('~a', 1.0, 0.5), '0.5 or more'), (Number('~a', 1.0, maximum=2), '2 or less'),
    (Number('~a', 1.0, -1e6, 1e6, infinite='max'), '-1e+06 to 1e+06, max'), (Integer('~a', 1, 0, 255), '0 to 255'),
    (Boolean('~a', True), 'true, false'), (Text('~a', 'b', ('b', 'c')), 'b, c'), (Text('~a', ''), ''),
    (Numbers('~a', [1.0]), ''),
])
def test_range_as_pages_write_it(parameter, text):
    assert parameter.range == text


STALE_TABLE = Table(Number('~rate', 10.0), Boolean('~strafe', False), Text('~shape', 'square'),
                    Numbers('~corners', [1]), Number('~size', Computed('by the shape')), Number('scale', 2.0))


@pytest.mark.parametrize('there, given, said', [
    ({}, (), None),
    ({'~rate': 10, '~strafe': False, '~shape': 'square', '~corners': [1]}, (), None),  # the defaults
    ({'~shape': 'circle', '~other': 5, 'scale': 7.0}, ('~shape',), None),
    ({'~shape': 'circle', '~strafe': True, '~rate': 5}, ('~rate',), 'shape=circle, strafe=true'),
    ({'~size': 2.0, '~corners': [[8, 6], [6, 8]]}, (), 'corners=[[8, 6], [6, 8]], size=2.0'),
])
def test_parameters_that_were_there_before_are_told(server, monkeypatch, logged, there, given, said):
    class Master:
        def parameters(self, names):
            return {rospy.resolve_name(name): there[name] for name in names if name in there}
    monkeypatch.setattr(parameters, 'Master', Master)
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    parameters.warn_of_stale(STALE_TABLE, {rospy.resolve_name(name) for name in given})
    assert logged == ([] if said is None else [
        f'{NODE} has parameters from an earlier run: {said}; rosparam delete {NODE} forgets them'])


UNKNOWN_TABLE = Table(Number('~rate', 10.0), Integer('~background_r', 69), Text('~image/format', 'jpeg'),
                      Number('scale', 2.0))


@pytest.mark.parametrize('stored, given, said', [
    ({}, (), []),
    ({'rate': 5, 'background_r': 0, 'image': {'format': 'png'}}, ('~rate',), []),
    ({'reat': 5}, ('~reat',), ['reat has no effect: this node has no such parameter. Did you mean _rate?']),
    ({'pen': 5}, ('~pen',), ['pen has no effect: this node has no such parameter. '
                             'It has background_r, image/format, rate.']),
    ({'backgruond_r': 5}, (), ['backgruond_r has no effect: this node has no such parameter. '
                               'Did you mean _background_r?']),
    ({'reat': 5, 'scale': 1.0, 'costmap': {'width': 3}}, (), []),  # of a launch file for another node of this kind
])
def test_parameters_that_the_node_does_not_have_are_told(server, logged, stored, given, said):
    parameters.warn_of_unknown(UNKNOWN_TABLE, {rospy.resolve_name(name) for name in given}, stored)
    assert logged == [f'parameter {rospy.resolve_name("~")}{text}' for text in said]


@pytest.mark.parametrize('answer, stored', [
    ([1, '', {'rate': 5, 'image': {'format': 'png'}}], {'rate': 5, 'image': {'format': 'png'}}),
    ([-1, 'not set', 0], {}), ([1, '', 5], {}), (parameters.NoMaster(), {}),
])
def test_what_the_master_has_below_the_name_of_the_node(monkeypatch, answer, stored):
    class Master:
        def request(self, calls):
            assert calls == [('getParam', NODE)]
            if isinstance(answer, Exception):
                raise answer
            return [answer]
    monkeypatch.setattr(parameters, 'Master', Master)
    monkeypatch.setattr(rospy, 'get_name', lambda: NODE)
    assert parameters.private() == stored


CLOCK_TABLE = Table(Number('~rate', 1.0), Boolean('~paused', False), run_only=True)
RUN_TABLE = Table(Integer('~background_r', 69), CLOCK_TABLE, Table(Text('~key', '', secret=True), run_only=True))


@pytest.mark.parametrize('stored, given, ends, said', [
    ({'background_r': 0, 'other': 5}, (), {}, None),  # stays, as with the original
    ({'rate': 1.0, 'paused': False}, (), {'rate': 1.0, 'paused': False}, None),
    ({'rate': 5, 'paused': True, 'background_r': 0}, (), {'rate': 5, 'paused': True}, 'paused=true, rate=5'),
    ({'rate': 5, 'paused': True}, ('~paused',), {'rate': 5}, 'rate=5'),  # that of the command line ends with it anyway
    ({'key': 'x'}, (), {'key': 'x'}, None),
])
def test_what_a_launch_file_says_about_one_run_ends_with_it(server, logged, stored, given, ends, said):
    found = parameters.of_launch(RUN_TABLE, {rospy.resolve_name(name) for name in given}, stored)
    assert found == {rospy.resolve_name(f'~{name}'): value for name, value in ends.items()}
    assert [text.partition(', because')[0] for text in logged] == ([] if said is None else [f'Started with {said}'])


def test_a_list_of_parameters_has_none_of_one_run_only(server):
    assert parameters.of_launch([Number('~rate', 1.0)], (), {'rate': 5}) == {}


@pytest.mark.parametrize('argument', [
    '_seed:=7', '_name:=text', '_a:=[1, 2.5, "x"]', '_a:={b: [true]}', '_a:=', '_a:=-2147483648', '_a:="2026-01-01"',
    '_a:=1e99', '__name:=[', 'topic:=[', 'no argument', '_a',
])
def test_values_of_a_command_line_that_a_master_can_store(argument):
    parameters.check_command_line(['node', argument])


@pytest.mark.parametrize('argument, said', [
    ('_background_r:=99999999999999999999', 'whole numbers from -2147483648 to 2147483647'),
    ('_seed:=2026-01-01', """type _seed:="'2026-01-01'\""""), ('_a:=~', 'not a value that a parameter can have'),
    ('_a:=[2147483648]', 'not a value'), ('_a:={1: 2}', 'not a value'), ('_corners:=[*x]', 'is not valid YAML'),
    ('_a:=[1', 'is not valid YAML'), ('_shape:=!!python/object/apply:os.getcwd []', 'is not valid YAML'),
])
def test_other_values_are_refused_before_the_master_is_asked(argument, said):
    with pytest.raises(parameters.ParameterError) as refused:
        parameters.check_command_line(['node', argument])
    assert str(refused.value).startswith(argument) and said in str(refused.value)
