"""The kinds of tests, their names, and which of them are selected.

The name of a test is KIND/PATH: unit/test/unit/test_docs.py::test_links, rostest/test/course/lesson_square.test. Tests
in test/cases have no file each; they are parametrized, and the parameter is the PATH: page/README.md, check/ruff.
"""
from functools import lru_cache
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
CASES = REPOSITORY / 'test' / 'cases'
TIME_LIMITS = {  # [s] for a test of each kind
    'unit': 300, 'check': 600, 'rostest': 600, 'grading': 900, 'stress': 300, 'page': 1800}
SLOW = (  # unit tests that take seconds of processor time or of waiting: --fast leaves them out
    'test_bench_markers.py', 'test_bent_paper.py', 'test_browser.py', 'test_browser_panels.py',
    'test_bundle_pose.py', 'test_bundle_training.py', 'test_camera_patterns.py', 'test_canvas.py',
    'test_class_grader.py', 'test_class_page.py', 'test_cmake.py', 'test_collection.py', 'test_collision.py',
    'test_console.py', 'test_cpp_programs.py', 'test_cv2_windows.py', 'test_demo_limits.py', 'test_depth.py',
    'test_detector.py', 'test_doctor.py', 'test_drives.py', 'test_edge_refiner.py', 'test_environments.py',
    'test_explained_photo.py', 'test_fits.py', 'test_frames.py', 'test_guard.py', 'test_integrations.py',
    'test_light.py', 'test_limits.py', 'test_live.py', 'test_malformed_files.py', 'test_many_markers.py',
    'test_mapper.py', 'test_marker_classes.py', 'test_marker_photo.py', 'test_marker_sequence.py', 'test_native.py',
    'test_nodes.py', 'test_notebooks.py', 'test_own_master.py', 'test_plain_codes.py', 'test_plain_import.py',
    'test_random_stimuli.py', 'test_remote.py', 'test_rendered_markers.py', 'test_renderer.py', 'test_response.py',
    'test_robot_world.py', 'test_root_package.py', 'test_rospy_repair.py', 'test_run_build.py', 'test_run_help.py',
    'test_run_link.py', 'test_run_shell.py', 'test_sandbox.py', 'test_sanitized.py', 'test_sensitivity.py',
    'test_sheet.py', 'test_static_analysis.py', 'test_student_copy.py', 'test_suite_programs.py', 'test_tracker.py',
    'test_turtle_world_reference.py', 'test_uneven_light.py', 'test_warm_start.py',
    'test_wheels.py', 'test_window.py')
COMPUTING = 'unit', 'check'  # the others start nodes, and so mostly wait
FAST = COMPUTING


@lru_cache(maxsize=None)
def real(path):
    """Return a path without symbolic links: a workspace has links to the packages."""
    return path.resolve()


def kind_of(path):
    """Return the kind of the tests in a file."""
    path = real(path)
    if path.suffix == '.test':
        return 'rostest'
    return path.stem[len('test_'):] if path.parent == CASES else 'unit'


def is_slow(path):
    """Return whether --fast leaves out the tests of a file."""
    return path.name in SLOW or real(path) == REPOSITORY / 'test' / 'unit' / 'test_launch_files.py'


def name_of(item):
    """Return KIND/PATH of a pytest item."""
    path, kind = item.path, kind_of(item.path)
    if kind == 'unit':
        function = item.nodeid.partition('::')[2]
        return f'{kind}/{relative(path)}::{function}'
    return f'{kind}/{relative(path) if kind == "rostest" else item.callspec.id}'


def relative(path):
    """Return the path of a file in the repository, as a text."""
    return real(path).relative_to(REPOSITORY).as_posix()


def may_hold(path, names):
    """Return whether the file ``path`` may hold a test that one of ``names`` selects; without names it may."""
    kind = kind_of(path)
    if not names or kind not in ('unit', 'rostest'):
        return True
    name = f'{kind}/{relative(path)}'
    return any(wanted in name or name in wanted or kind == 'unit' and _holds(path, wanted) for wanted in names)


def _holds(path, wanted):
    """Return whether ``wanted`` names a function of the file: test_corners, test_shapes.py::test_corners[4]."""
    file, _, function = wanted.rpartition('::')
    return file in f'unit/{relative(path)}' and f'def {function.partition("[")[0]}(' in path.read_text(encoding='utf-8')


def is_selected(name, names):
    """Return whether one of ``names`` is a part of ``name``; without names, all are selected."""
    return not names or any(wanted in name for wanted in names)
