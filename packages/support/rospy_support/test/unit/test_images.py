"""rospy_support.images: every encoding from a picture with known colours, and unusable data."""
import io

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from rospy_support import images

HEIGHT, WIDTH = 6, 8
ORANGE = (40, 120, 220)  # blue, green, red
ORANGE_GREY = 0.114 * 40 + 0.587 * 120 + 0.299 * 220  # Rec. 601
ROUNDED = 1.01  # grey values: a rounding of 8 bits
CONVERTED = 3.0  # grey values: two roundings and the limits of YUV

COLOUR_ORDERS = {'rgb': (2, 1, 0), 'bgr': (0, 1, 2), 'rgba': (2, 1, 0, 3), 'bgra': (0, 1, 2, 3)}
BAYER_COLOURS = {'r': 2, 'g': 1, 'b': 0}


def image(encoding, array, big=False, padding=0):
    """An Image of an array (height, width[, channels]) whose rows are followed by ``padding`` bytes."""
    stored = array.astype(array.dtype.newbyteorder('>' if big else '<'))
    rows = [row.tobytes() + b'\xee' * padding for row in stored]
    return Image(height=array.shape[0], width=array.shape[1], encoding=encoding, is_bigendian=int(big),
                 step=len(rows[0]), data=b''.join(rows))


def orange(encoding):
    """The array of a flat orange picture in an encoding, made by hand."""
    name, bits = (encoding[:-2], 16) if encoding.endswith('16') else (encoding[:-1], 8)
    colours = np.array([*ORANGE, 255])
    if name.startswith('bayer_'):
        pattern = name[len('bayer_'):]
        tile = colours[[BAYER_COLOURS[c] for c in pattern]].reshape(2, 2)
        array = np.tile(tile, (HEIGHT // 2, WIDTH // 2))
    else:
        array = np.tile(colours[list(COLOUR_ORDERS[name])], (HEIGHT, WIDTH, 1))
    return array.astype(np.uint8) if bits == 8 else (array * 257).astype(np.uint16)


COLOURED = [f'{name}{bits}' for name in (*COLOUR_ORDERS, *(f'bayer_{p}' for p in ('rggb', 'bggr', 'gbrg', 'grbg')))
            for bits in (8, 16)]


@pytest.mark.parametrize('big', [False, True])
@pytest.mark.parametrize('padding', [0, 6])
@pytest.mark.parametrize('encoding', COLOURED)
def test_colours_are_right_in_every_encoding(encoding, padding, big):
    message = image(encoding, orange(encoding), big, padding)
    assert np.abs(images.bgr(message).astype(float) - ORANGE).max() <= ROUNDED
    assert np.abs(images.grey(message) - ORANGE_GREY).max() <= ROUNDED
    assert images.grey(message).shape == (HEIGHT, WIDTH) and images.bgr(message).shape == (HEIGHT, WIDTH, 3)


@pytest.mark.parametrize('encoding', ['mono8', '8UC1', 'mono16', '16UC1'])
def test_grey_pictures_keep_every_pixel_in_its_place(encoding):
    values = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH)
    array = (values * 257).astype(np.uint16) if '16' in encoding else values.astype(np.uint8)
    for big in (False, True):
        message = image(encoding, array, big, padding=2)
        assert (images.grey(message) == values).all()
        assert (images.bgr(message) == values[..., None]).all()
        assert (images.pixels(message) == array).all()


@pytest.mark.parametrize('encoding, luma, chroma', [('yuv422', 1, 0), ('yuv422_yuy2', 0, 1)])
def test_yuv_pictures(encoding, luma, chroma):
    """Rec. 601 in video range: Y = 16 + 219/255 grey; V above 128 is red, U above 128 is blue."""
    array = np.full((HEIGHT, WIDTH, 2), 128, np.uint8)
    array[..., luma] = np.arange(60, 60 + WIDTH)
    grey = (np.arange(60, 60 + WIDTH) - 16) * 255 / 219
    assert np.abs(images.bgr(image(encoding, array)) - grey[:, None]).max() <= CONVERTED
    assert (np.diff(images.grey(image(encoding, array)).astype(int), axis=1) == 1).all()
    array[:, 1::2, chroma] = 200  # V of each pair
    blue, _, red = images.bgr(image(encoding, array))[0, 0].astype(int)
    assert red > blue + 50
    array[:, 1::2, chroma], array[:, 0::2, chroma] = 128, 200
    blue, _, red = images.bgr(image(encoding, array))[0, 0].astype(int)
    assert blue > red + 50


def test_a_plain_picture_is_not_copied():
    message = image('mono8', np.zeros((480, 640), np.uint8))
    assert images.grey(message).base is not None
    assert np.shares_memory(images.pixels(message), np.frombuffer(message.data, np.uint8))


def changed(**fields):
    message = image('rgb8', orange('rgb8'))
    for name, value in fields.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize('message, said', [
    (changed(encoding='rgb9'), "encoding 'rgb9' is unknown; the known ones are: 16UC1, .*, bayer_rggb8, .*rgb8"),
    (changed(encoding=''), "encoding '' is unknown"),
    (changed(encoding='32FC1'), "encoding '32FC1' is unknown"),
    (changed(width=0), 'an image of 0x6 pixels has no pixels'),
    (changed(height=0), 'an image of 8x0 pixels has no pixels'),
    (changed(step=23), 'step is 23 bytes; a row of 8 pixels in rgb8 has 24'),
    (changed(step=0), 'step is 0 bytes'),
    (changed(encoding='rgb16', step=49), 'step is 49 bytes; a row of 8 pixels in rgb16 has 48'),
    (changed(data=b''), 'has 0 bytes of data, 144 are needed; is it cut off?'),
    (changed(data=bytes(143)), 'has 143 bytes of data, 144 are needed'),
    (changed(width=4000000000, step=4294967295), 'step is 4294967295 bytes'),
    (changed(height=4000000000), '96000000000 are needed'),
    (changed(encoding='yuv422', width=7), 'an image of 7x6 pixels in yuv422 needs an even width'),
])
def test_what_is_no_picture_is_refused_with_the_reason(message, said):
    for convert in (images.grey, images.bgr, images.pixels):
        with pytest.raises(images.ImageError, match=said):
            convert(message)


def test_the_last_row_needs_no_padding():
    message = image('mono8', np.ones((HEIGHT, WIDTH), np.uint8), padding=5)
    message.data = message.data[:-5]
    assert (images.grey(message) == 1).all()


@pytest.mark.parametrize('array, encoding, expected', [
    (np.zeros((3, 4), np.uint8), None, 'mono8'), (np.zeros((3, 4), np.uint16), None, 'mono16'),
    (np.zeros((3, 4, 3), np.uint8), None, 'bgr8'), (np.zeros((3, 4, 4), np.uint8), None, 'bgra8'),
    (np.zeros((3, 4, 3), np.uint8), 'rgb8', 'rgb8'), (np.zeros((3, 4), np.uint8), 'bayer_gbrg8', 'bayer_gbrg8'),
])
def test_an_array_becomes_a_message_and_comes_back(array, encoding, expected):
    array = np.random.default_rng(1).integers(0, 255, array.shape).astype(array.dtype)
    message = images.to_image(array[:, ::-1], encoding, Header(frame_id='camera'))
    assert (message.encoding, message.header.frame_id) == (expected, 'camera')
    buffer = io.BytesIO()
    message.serialize(buffer)
    received = Image().deserialize(buffer.getvalue())
    assert (images.pixels(received) == array[:, ::-1]).all()


@pytest.mark.parametrize('encoding, array, step', [
    ('rgb8', np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3), 9),
    (images.DEPTH, np.arange(6, dtype=np.float32).reshape(2, 3), 12),
])
def test_fields_of_an_image(encoding, array, step):
    message = images.to_image(array, encoding)
    assert (message.height, message.width, message.encoding, message.step) == (2, 3, encoding, step)
    assert np.array_equal(np.frombuffer(message.data, array.dtype), array.ravel()) and not message.is_bigendian


@pytest.mark.parametrize('array, encoding', [
    (np.zeros((3, 4), np.uint8), images.DEPTH),
    (np.zeros((3, 4)), None), (np.zeros((3, 4, 2), np.uint8), None), (np.zeros(3, np.uint8), None),
    (np.zeros((3, 4), np.uint8), 'bgr8'), (np.zeros((3, 4, 3), np.uint8), 'rgb9'),
    (np.zeros((3, 4, 3), np.uint16), 'bgr8'),
])
def test_an_array_that_is_no_picture_is_refused(array, encoding):
    with pytest.raises(images.ImageError, match='is not an image in'):
        images.to_image(array, encoding)


@pytest.mark.parametrize('kind, tolerance', [('png', 0), ('jpeg', 3)])
def test_compressed_pictures(kind, tolerance):
    array = np.full((40, 50, 3), ORANGE, np.uint8)
    message = images.to_compressed(array, kind)
    assert message.format == f'bgr8; {kind} compressed bgr8'
    assert np.abs(images.bgr(message).astype(int) - ORANGE).max() <= tolerance
    assert np.abs(images.grey(message) - ORANGE_GREY).max() <= tolerance + ROUNDED


def test_compressed_picture_is_described_as_image_transport_does():
    colour, grey = np.zeros((4, 5, 3), np.uint8), np.zeros((4, 5), np.uint8)
    header = Header(frame_id='camera')
    assert images.to_compressed(colour, 'png', header, 'rgb8').format == 'rgb8; png compressed bgr8'
    assert images.to_compressed(grey, 'jpeg', header).format == 'mono8; jpeg compressed '
    assert images.to_compressed(grey, 'jpeg', header).header is header


def test_quality_of_a_jpeg():
    noise = np.random.default_rng(1).integers(0, 255, (40, 50)).astype(np.uint8)
    sizes = [len(images.to_compressed(noise, options=(cv2.IMWRITE_JPEG_QUALITY, quality)).data) for quality in (20, 90)]
    assert sizes[0] < 0.5 * sizes[1]


def test_a_compressed_picture_is_not_turned_by_what_exif_says():
    """A camera held upright writes Orientation 6; its matrix is that of the sensor."""
    exif = (b'\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0')
    plain = images.to_compressed(np.zeros((40, 50), np.uint8)).data
    turned = CompressedImage(format='jpeg', data=plain[:2] + exif + plain[2:])
    assert cv2.imdecode(np.frombuffer(turned.data, np.uint8), cv2.IMREAD_GRAYSCALE).shape == (50, 40)
    assert images.grey(turned).shape == (40, 50)


@pytest.mark.parametrize('kind', ['png', 'jpeg'])
def test_cut_off_and_foreign_data_are_refused(kind):
    whole = images.to_compressed(np.random.default_rng(1).integers(0, 255, (40, 50)).astype(np.uint8), kind)
    for data, said in ((whole.data[:-100], 'it is cut off'), (whole.data[:20], 'it is cut off'),
                       (b'', 'OpenCV does not know'), (b'no picture at all', 'OpenCV does not know')):
        with pytest.raises(images.ImageError, match=said):
            images.grey(CompressedImage(format=kind, data=data))


def test_cloud_has_points_and_colours():
    points = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
    colour = np.zeros((2, 3, 3), np.uint8)
    colour[1, 2] = 0x56, 0x34, 0x12
    message = images.to_cloud(points, colour, 'bgr8', Header())
    assert (message.height, message.width, message.point_step, message.row_step) == (2, 3, 16, 48)
    data = np.frombuffer(message.data, np.float32).reshape(2, 3, 4)
    assert np.array_equal(data[..., :3], points)
    assert data[..., 3].view(np.uint32)[1, 2] == 0x123456
    assert [(field.name, field.offset, field.datatype) for field in message.fields] == [
        ('x', 0, 7), ('y', 4, 7), ('z', 8, 7), ('rgb', 12, 7)]
