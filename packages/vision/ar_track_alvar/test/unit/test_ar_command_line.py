"""ar_track_alvar.core.command_line: the deprecated form becomes remappings and private parameters."""
import pytest
from rospy.client import load_command_line_node_params

from ar_track_alvar.core.command_line import (
    UsageError,
    bundle_arguments,
    depth_bundle_arguments,
    ros_arguments,
    training_arguments,
)

SHORT = ['4.4', '0.08', '0.2', '/cam/image', '/cam/info', '/map']


def test_the_short_form():
    arguments = ros_arguments(SHORT)
    assert 'camera_image:=/cam/image' in arguments and 'camera_info:=/cam/info' in arguments
    assert load_command_line_node_params(arguments) == {
        'marker_size': 4.4, 'max_new_marker_error': 0.08, 'max_track_error': 0.2, 'output_frame': '/map'}


def test_the_long_form():
    assert load_command_line_node_params(ros_arguments(SHORT + ['15', '7', '1'])) == {
        'marker_size': 4.4, 'max_new_marker_error': 0.08, 'max_track_error': 0.2, 'output_frame': '/map',
        'max_frequency': 15, 'marker_resolution': 7, 'marker_margin': 1}


@pytest.mark.parametrize('word, value', [('5', 5), ('5.0', 5), ('1e-2', 0.01), ('0.00001', 0.00001), ('-1', -1)])
def test_numbers_stay_numbers(word, value):
    assert load_command_line_node_params(ros_arguments([word] + SHORT[1:]))['marker_size'] == value


def test_a_frame_may_look_like_a_number():
    assert load_command_line_node_params(ros_arguments(SHORT[:5] + ['007']))['output_frame'] == '007'


def test_bundle_files_come_after_the_frame():
    arguments = bundle_arguments([*SHORT, '/a/b.xml', 'with blank.xml', '7'])
    assert load_command_line_node_params(arguments) == {
        'marker_size': 4.4, 'max_new_marker_error': 0.08, 'max_track_error': 0.2, 'output_frame': '/map',
        'bundle_files': "/a/b.xml 'with blank.xml' 7"}
    assert load_command_line_node_params(bundle_arguments([*SHORT, '7']))['bundle_files'] == '7'


def test_the_median_filter_comes_before_the_bundle_files_of_a_depth_camera():
    arguments = depth_bundle_arguments([*SHORT, '10', 'a.xml', 'b.xml'])
    found = load_command_line_node_params(arguments)
    assert (found['med_filt_size'], found['bundle_files'], found['output_frame']) == (10, 'a.xml b.xml', '/map')


@pytest.mark.parametrize('words, said', [([*SHORT, '10'], '7 arguments are given; at least 8 are needed'),
                                         ([*SHORT, 'ten', 'a.xml'], "MED_FILT_SIZE is 'ten'; a number is needed")])
def test_what_is_not_the_form_of_a_depth_camera_is_refused(words, said):
    with pytest.raises(UsageError, match=said):
        depth_bundle_arguments(words)


def test_the_number_of_markers_comes_before_all_others_of_training():
    assert load_command_line_node_params(training_arguments(['8', *SHORT])) == {
        'nof_markers': 8, 'marker_size': 4.4, 'max_new_marker_error': 0.08, 'max_track_error': 0.2,
        'output_frame': '/map'}
    with pytest.raises(UsageError, match='6 arguments are given; 7 are needed'):
        training_arguments(SHORT)


@pytest.mark.parametrize('words, said', [
    (SHORT, '6 arguments are given; at least 7 are needed'),
    ([], '0 arguments are given; at least 7 are needed'),
    (['big', *SHORT[1:], 'a.xml'], "MARKER_SIZE is 'big'; a number is needed"),
])
def test_bundles_need_files(words, said):
    with pytest.raises(UsageError, match=said):
        bundle_arguments(words)


@pytest.mark.parametrize('words, said', [
    (SHORT[:5], '5 arguments are given; at least 6 are needed'),
    (SHORT + ['8', '5', '2', 'more'], '10 arguments are given; at most 9 are allowed'),
    (['big'] + SHORT[1:], "MARKER_SIZE is 'big'; a number is needed"),
    (SHORT + ['fast'], "MAX_FREQUENCY is 'fast'"),
    (SHORT[:2] + ['inf'] + SHORT[3:], "MAX_TRACK_ERROR is 'inf'"),
    (['nan'] + SHORT[1:], "MARKER_SIZE is 'nan'"),
])
def test_what_is_of_neither_form_is_refused(words, said):
    with pytest.raises(UsageError, match=said):
        ros_arguments(words)
