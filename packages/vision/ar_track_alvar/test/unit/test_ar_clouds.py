"""Point clouds: every layout of drivers is read, and unusable clouds are refused with the reason."""
import struct
import types

import numpy as np
import pytest

from ar_track_alvar.core.clouds import Cloud, CloudError

HEIGHT, WIDTH = 3, 4
FLOAT, DOUBLE, WORD, BYTE = 7, 8, 6, 2


def field(name, offset, datatype=FLOAT):
    return types.SimpleNamespace(name=name, offset=offset, datatype=datatype, count=1)


def cloud(order='<', number='f', colour='rgb', datatype=FLOAT, pad=0, row_pad=0, **changes):
    """Return a cloud whose point (row, column) is at (column, row, 5) and red = row, green = column, blue = 7."""
    size = struct.calcsize(number)
    data = b''
    for row in range(HEIGHT):
        for column in range(WIDTH):
            data += struct.pack(f'{order}3{number}', column, row, 5.0)
            data += bytes((row, column, 7, 0)) if colour == 'apart' else \
                struct.pack(f'{order}I', 200 << 24 | row << 16 | column << 8 | 7)
            data += b'\xee' * pad
        data += b'\xdd' * row_pad
    end = 3 * size
    fields = [field(name, size * k, FLOAT if number == 'f' else DOUBLE) for k, name in enumerate('xyz')]
    fields += [field(name, end + k, BYTE) for k, name in enumerate('rgb')] if colour == 'apart' else \
        [field(colour, end, datatype)]
    step = end + 4 + pad
    made = {'height': HEIGHT, 'width': WIDTH, 'fields': fields, 'is_bigendian': order == '>', 'point_step': step,
            'row_step': step * WIDTH + row_pad, 'data': data}
    return types.SimpleNamespace(**{**made, **changes})


@pytest.mark.parametrize('layout', [{}, {'order': '>'}, {'number': 'd'}, {'colour': 'rgba', 'datatype': WORD},
                                    {'colour': 'rgba', 'datatype': WORD, 'order': '>'}, {'colour': 'apart'},
                                    {'pad': 16}, {'row_pad': 5}, {'order': '>', 'pad': 3, 'row_pad': 7}])
def test_points_and_colours_are_read(layout):
    read = Cloud(cloud(**layout))
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    assert np.array_equal(read.bgr(), np.stack([np.full_like(rows, 7), columns, rows], -1))
    assert np.array_equal(read.window(1, 3, 0, 2), np.stack([columns, rows, np.full_like(rows, 5)], -1)[1:3, :2])
    assert read.grey().shape == read.shape == (HEIGHT, WIDTH)


def test_a_last_row_without_its_padding_is_read():
    whole = cloud(row_pad=5)
    whole.data = whole.data[:-5]
    assert Cloud(whole).shape == (HEIGHT, WIDTH)


@pytest.mark.parametrize('changes, reason', [
    ({'height': 1, 'width': 12}, 'not organised'), ({'height': 0}, 'not organised'),
    ({'height': 100000, 'width': 100000}, 'at most'), ({'row_step': 10}, 'row_step is 10'),
    ({'point_step': 0}, 'row_step is'), ({'data': b'\0' * 20}, 'is it cut off'),
    ({'fields': [field('x', 0), field('y', 4), field('rgb', 12)]}, 'z is missing'), ({'fields': []}, 'among none'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 8)]}, 'no colours'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 8), field('intensity', 12)]}, 'has intensity, x, y, z'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 8, BYTE), field('rgb', 12)]}, 'z has the datatype 2'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 14), field('rgb', 12)]}, 'does not fit'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 8), field('rgb', 12, DOUBLE)]}, 'rgb has the datatype 8'),
    ({'fields': [field('x', 0), field('y', 4), field('z', 8), field('rgb', 14)]}, 'does not fit')])
def test_an_unusable_cloud_is_refused_with_the_reason(changes, reason):
    with pytest.raises(CloudError, match=reason):
        Cloud(cloud(**changes))
