"""ar_track_alvar.diagnostics: the report of a second."""
from types import SimpleNamespace

import genpy
from diagnostic_msgs.msg import DiagnosticStatus

from ar_track_alvar.diagnostics import Statistics

STAMP = genpy.Time(5)


def report(statistics, elapsed=1.0, enabled=True):
    array = statistics.report('/ns/tracker', elapsed, enabled, STAMP)
    return array.status[0], {entry.key: entry.value for entry in array.status[0].values}


def test_rate_times_and_markers_are_those_of_the_last_second():
    statistics = Statistics()
    for milliseconds, count in ((4, 1), (6, 2), (50, 3), (8, 0)):
        found = [SimpleNamespace(ambiguous=number == 0, bend=0.1 * number, doubtful=number == 1)
                 for number in range(count)]
        statistics.searched(milliseconds / 1000, found)
        statistics.published(milliseconds / 500)
    status, values = report(statistics, elapsed=2.0)
    assert (status.level, status.name, status.message) == (DiagnosticStatus.OK, 'ns/tracker: markers',
                                                           '2.0 images per second')
    assert values['rate [Hz]'] == '2.00' and values['time per image [ms]'] == '7.00'
    assert values['time from image to message [ms]'] == '14.00' and values['markers per image'] == '1.50'
    assert values['markers with ambiguous orientation'] == '3'
    assert values['markers on bent paper'] == '3' and values['markers with doubtful orientation'] == '2'
    status, values = report(statistics)
    assert (values['rate [Hz]'], values['time per image [ms]'], values['markers per image']) == (
        '0.00', 'none', '0.00')


def test_what_was_left_out_is_counted_since_the_start():
    statistics = Statistics()
    statistics.skipped, statistics.dropped, statistics.refused, statistics.missing_transforms = 1, 2, 3, 4
    for _ in range(2):
        _, values = report(statistics)
        assert [values[key] for key in ('images beyond max_frequency', 'images dropped', 'images refused',
                                        'markers without transform')] == ['1', '2', '3', '4']


def test_a_trouble_is_a_warning_until_it_is_over():
    statistics = Statistics()
    statistics.trouble('no picture')
    status, _ = report(statistics)
    assert (status.level, status.message) == (DiagnosticStatus.WARN, 'no picture')
    assert report(statistics)[0].level == DiagnosticStatus.OK


def test_disabled_is_no_trouble():
    status, values = report(Statistics(), enabled=False)
    assert (status.level, status.message, values['enabled']) == (DiagnosticStatus.OK, 'disabled', 'False')
