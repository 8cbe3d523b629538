"""course_grader.attempt.recording_reader: recordings that are read along."""
import pytest

from course_grader.attempt.recording_reader import RecordingReader
from course_grader.rules.observation import Observed
from kinematic_core.timing.recorder import ACTIVE

HEAD = 'tick,event,x,y,theta,callers\n'
DT = 0.016


def test_what_was_done_before_the_program_was_there_comes_first(tmp_path):
    path, observed = tmp_path / 'record.csv', Observed()
    path.write_text(HEAD + '0,,5,5,0,\n50,pen 0 0 0 3 0,5,5,0,/student\n60,,5,5,0,\n')
    reader = RecordingReader(str(path), DT, observed)
    observed.start = reader.read()
    assert observed.start == pytest.approx(60 * DT) and reader.now == 0.0
    with open(path, 'a', encoding='utf-8') as file:
        file.write('61,teleport_absolute 2.0 2.0 0.0,2,2,0,/student\n62,cmd 1.0 0.0 0.0,2,2,0,=\n')
    assert reader.read() == pytest.approx(62 * DT)
    assert observed.seconds == pytest.approx(2 * DT) and observed.commands == []
    pen, teleport = observed.events
    assert (pen.kind, teleport.kind) == ('pen', 'teleport') and pen.t < observed.start < teleport.t
    assert [sample.t for sample in observed.track] == sorted(sample.t for sample in observed.track)
    assert observed.pens()[-1] == (0, 0, 0, 3, 0) and observed.pens()[0] is None


@pytest.mark.parametrize('suffix', ['', ACTIVE])
def test_a_row_that_is_cut_waits_for_its_rest(tmp_path, suffix):
    path, observed = tmp_path / 'record.csv', Observed()
    reader = RecordingReader(str(path), DT, observed)
    assert reader.read() == 0.0
    with open(str(path) + suffix, 'w', encoding='utf-8', buffering=1) as file:
        file.write(HEAD + '0,,5,5,0,\n1,,5.25')
        file.flush()
        reader.read()
        assert [sample.x for sample in observed.track] == [5.0]
        file.write('9,5,0,\n')
        reader.read()
        assert [sample.x for sample in observed.track] == [5.0, 5.259]
        reader.close()
        file.write('2,,5,5,0,\n')
        reader.read()
        assert len(observed.track) == 2
