"""turtlesim.core.replay: recordings of the real turtlesim come out equal; what is not equal is found and told."""
import shutil
import struct
import subprocess
import sys

import pytest

from turtlesim.core import replay
from unit_support.packages import REPOSITORY
from unit_support.recordings import COLUMNS, read, write

GOLDEN = REPOSITORY / 'test' / 'data' / 'golden'
RECORDINGS = sorted(GOLDEN.glob('*.csv'))
HEADER = ','.join(COLUMNS)
ROW = '0,,5.54444456,5.54444456,0,0,0,69,86,255'  # turtle1 at rest in the middle, on the background
MIDDLE = ROW[3:]


@pytest.fixture
def straight(tmp_path):
    """A golden recording of 159 ticks with its picture, to tamper with."""
    for name in ('straight.csv', 'straight.png'):
        shutil.copyfile(GOLDEN / name, tmp_path / name)
    return tmp_path / 'straight.csv'


def next_float32(text):
    (bits,) = struct.unpack('<i', struct.pack('<f', float(text)))
    return f'{struct.unpack("<f", struct.pack("<i", bits + 1))[0]:.9g}'


def test_all_recordings_at_once_exit_with_0_and_a_line_each(capsys):
    assert replay.main([str(path) for path in RECORDINGS]) == 0
    output = capsys.readouterr()
    assert output.err == ''
    lines = output.out.splitlines()
    assert len(lines) == len(RECORDINGS) >= 8
    for line, path in zip(lines, RECORDINGS):
        ticks = len(read(path))
        assert line.startswith(f'{path}: {ticks} ticks, 0 with a different pose, 100.00 % of the colours equal')
        assert line.endswith(', 100.0000 % of the pixels equal')


@pytest.mark.parametrize('field', ['x', 'y', 'linear_velocity'])
@pytest.mark.parametrize('tick', [0, 77, 158])
def test_one_last_bit_of_one_pose_is_found_with_its_tick(straight, field, tick, capsys):
    rows = read(straight)
    recorded = rows[tick][field]
    rows[tick][field] = next_float32(recorded)
    write(straight, rows)
    assert replay.main([str(straight)]) == 1
    output = capsys.readouterr().out
    assert '159 ticks, 1 with a different pose, 100.00 % of the colours' in output
    assert f'first difference: tick {tick}: recorded x=' in output
    recorded_text, here_text = output.split('first difference: ')[1].split('; here ')
    assert f'{field}={float(rows[tick][field])!r}' in recorded_text
    here = float(here_text.split(f'{field}=')[1].split(',')[0].rstrip(')\n'))
    assert f'{here:.9g}' == recorded


def test_sign_of_zero_is_a_bit_of_the_pose(straight):
    rows = read(straight)
    assert rows[3]['theta'] == '0'
    rows[3]['theta'] = '-0.0'
    write(straight, rows)
    assert replay.replay(str(straight)).different_poses == 1


def test_every_different_pose_is_counted_and_the_first_is_told(straight):
    rows = read(straight)
    for tick in (50, 51, 90):
        rows[tick]['y'] = '1'
    write(straight, rows)
    result = replay.replay(str(straight))
    assert result.different_poses == 3
    assert result.first_difference.startswith('tick 50: ')


@pytest.mark.parametrize('channel', 'rgb')
def test_a_different_colour_lowers_the_share_but_is_no_failure(straight, channel, capsys):
    rows = read(straight)
    rows[40][channel] = str(int(rows[40][channel]) ^ 1)
    write(straight, rows)
    assert replay.replay(str(straight)).different_colours == [40]
    assert replay.main([str(straight)]) == 0
    # 158 / 159 = 99.371 %
    assert '0 with a different pose, 99.37 % of the colours equal, 100.0000 %' in capsys.readouterr().out


def test_missing_picture_is_said(straight, capsys):
    straight.with_suffix('.png').unlink()
    assert replay.main([str(straight)]) == 0
    assert replay.replay(str(straight)).equal_pixels is None
    assert capsys.readouterr().out.endswith('100.00 % of the colours equal, no picture\n')


def test_different_pixels_lower_the_share(straight, capsys):
    import cv2
    picture = cv2.imread(str(straight.with_suffix('.png')))
    picture[:5, :5, 0] ^= 1  # 25 of 250,000 pixels = 0.01 %, by one step of one channel
    cv2.imwrite(str(straight.with_suffix('.png')), picture)
    assert replay.main([str(straight)]) == 0
    assert '99.9900 % of the pixels equal' in capsys.readouterr().out


@pytest.mark.parametrize('content', ['size', 'text', 'empty'])
def test_a_file_that_is_no_picture_of_the_canvas_is_refused_by_name(straight, content, capfd):
    picture = straight.with_suffix('.png')
    if content == 'size':
        import cv2
        cv2.imwrite(str(picture), cv2.imread(str(picture))[:499])
    else:
        picture.write_text('no picture' if content == 'text' else '')
    assert replay.main([str(straight)]) == 2
    assert f'{picture}: not an image of 500 x 500 pixels\n' in capfd.readouterr().err


def test_unrecorded_ticks_are_stepped_through(straight):
    rows = [row for row in read(straight) if row['event'] or int(row['tick']) % 10 == 9]
    assert len(rows) < 25
    write(straight, rows)
    result = replay.replay(str(straight))
    assert (result.ticks, result.different_poses, result.different_colours) == (len(rows), 0, [])


def test_recording_may_begin_with_any_number(tmp_path):
    path = tmp_path / 'late.csv'
    path.write_text('\n'.join([HEADER] + [f'{tick},,{MIDDLE}' for tick in (1000, 1001, 1005)]) + '\n')
    result = replay.replay(str(path))
    assert (result.ticks, result.different_poses) == (3, 0)


@pytest.mark.parametrize('cut', range(1, 12))
def test_last_row_that_is_cut_is_left_out(straight, capsys, cut):
    """However much of it is missing: what is left of a number may be one, too."""
    content, ticks = straight.read_bytes(), replay.replay(str(straight)).ticks
    assert capsys.readouterr().err == ''
    straight.write_bytes(content[:-cut])
    result = replay.replay(str(straight))
    assert (result.ticks, result.different_poses, result.different_colours) == (ticks - 1, 0, [])
    assert 'the last row is incomplete' in capsys.readouterr().err


def test_reset_and_several_events_of_one_tick_take_effect_in_their_order(tmp_path):
    path = tmp_path / 'events.csv'
    rows = ['0,cmd 1 0 0 ; reset;teleport_absolute 1 2 0; teleport_relative 1 0,2,2,0,0,0,179,184,255',
            '1,reset,' + MIDDLE, '2,,' + MIDDLE]
    path.write_text('\n'.join([HEADER, *rows, '']))
    result = replay.replay(str(path))
    assert (result.different_poses, result.different_colours) == (0, [])


MALFORMED = {  # name: (content, texts that the message has)
    'empty': ('', ['contains no ticks']),
    'header alone': (HEADER + '\n', ['contains no ticks']),
    'another table': ('name,size\nfoo,3\n', ['line 2', 'the columns are tick, event, x, y']),
    'a column missing': (HEADER[:-2] + '\n' + ROW[:-4], ['line 2', "'b'"]),
    'no header': (f'{ROW}\n{ROW}', ['line 2', 'the columns are']),
    'short row': (f'{HEADER}\n{ROW}\n1,,5.5,5.5\n', ['line 3']),
    'row of one field': (f'{HEADER}\n{ROW}\n1\n', ['line 3']),
    'words for numbers': (f'{HEADER}\n{ROW}\n{ROW.replace("86", "green")}', ['line 3', 'green']),
    'tick of halves': (f'{HEADER}\n0.5{ROW[1:]}', ['line 2', '0.5']),
    'beyond float32': (f'{HEADER}\n{ROW}\n0,,1e300,{ROW.split(",", 3)[3]}', ['line 3', 'float']),
    'unknown event': (f'{HEADER}\n{ROW}\n7,dance 3,{MIDDLE}',
                      ['tick 7', "unknown event 'dance'", 'cmd, pen, teleport']),
    'too few values': (f'{HEADER}\n{ROW}\n7,cmd 1 2,{MIDDLE}', ['tick 7', 'event cmd [1.0, 2.0]']),
    'too many values': (f'{HEADER}\n{ROW}\n7,clear 1,{MIDDLE}', ['tick 7', 'event clear [1.0]']),
    'event of words': (f'{HEADER}\n{ROW}\n7,cmd fast 0 0,{MIDDLE}', ['line 3', 'fast']),
    'nan command': (f'{HEADER}\n{ROW}\n7,cmd nan 0 0,{MIDDLE}', ['tick 7', 'linear.x is nan', 'finite number']),
    'absurd teleport': (f'{HEADER}\n7,teleport_absolute 1e9 0 0,{MIDDLE}', ['tick 7', 'x is 1e+09', 'it must be']),
    'pen too wide': (f'{HEADER}\n7,pen 0 0 0 256 0,{MIDDLE}', ['tick 7', 'width is 256', '0 to 255']),
    'nan pen': (f'{HEADER}\n7,pen nan 0 0 1 0,{MIDDLE}', ['tick 7', 'event pen [nan', 'NaN']),
    'infinite pen': (f'{HEADER}\n7,pen inf 0 0 1 0,{MIDDLE}', ['tick 7', 'event pen [inf', 'infinity']),
    'not utf-8': (b'\xff\xfe\x00\x01' * 10, ['not a text file']),
    'zeros': (f'{HEADER}\n{ROW}\n\0\0\0\n', ['line']),
}


@pytest.mark.parametrize('content, texts', MALFORMED.values(), ids=MALFORMED.keys())
def test_malformed_recording_ends_with_2_and_a_text_of_file_place_and_reason(tmp_path, capsys, content, texts):
    path = tmp_path / 'bad.csv'
    path.write_bytes((content if isinstance(content, bytes) else content.encode()) + b'\n' * bool(content))
    assert replay.main([str(path)]) == 2
    output = capsys.readouterr()
    assert output.err.startswith(f'{path}: ')
    assert output.err.count('\n') == 1
    for text in texts:
        assert text in output.err
    assert output.out == ''


def test_missing_file_and_folder_end_with_2_by_name(tmp_path, capsys):
    for path in (tmp_path / 'nowhere.csv', tmp_path):
        assert replay.main([str(path)]) == 2
        assert str(path) in capsys.readouterr().err


@pytest.mark.parametrize('order, status', [('good', 0), ('other', 1), ('bad', 2), ('good other', 1), ('other good', 1),
                                           ('bad other', 2), ('other bad', 2), ('bad good', 2)])
def test_exit_code_is_the_worst_of_all_files_and_every_file_is_looked_at(tmp_path, capsys, order, status):
    (tmp_path / 'good').write_text(f'{HEADER}\n{ROW}\n')
    (tmp_path / 'other').write_text(f'{HEADER}\n{ROW.replace("5.5", "6.5")}\n')
    (tmp_path / 'bad').write_text('nothing')
    assert replay.main([str(tmp_path / name) for name in order.split()]) == status
    output = capsys.readouterr()
    replayed = [line for line in output.out.splitlines() if ' ticks, ' in line]
    bad = order.count('bad')
    assert (len(replayed), len(output.err.splitlines())) == (len(order.split()) - bad, bad)


def test_without_files_the_usage_is_shown(capsys):
    with pytest.raises(SystemExit) as end:
        replay.main([])
    assert end.value.code == 2
    assert 'usage: ./run replay' in capsys.readouterr().err


def test_exit_code_reaches_the_shell(tmp_path):
    path = tmp_path / 'other.csv'
    path.write_text(f'{HEADER}\n{ROW.replace("5.5", "6.5")}\n')
    result = subprocess.run([sys.executable, '-m', 'turtlesim.core.replay', str(path)], capture_output=True, text=True,
                            timeout=20.0, check=False)
    assert (result.returncode, result.stderr) == (1, '')
    assert '1 with a different pose' in result.stdout
