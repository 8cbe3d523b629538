"""usb_cam.core.sources: folders and videos for real, the webcam with OpenCV's capture played by a recording."""
import os
import time

import cv2
import numpy as np
import pytest

from usb_cam.core.sources import EndOfSource, Settings, SourceError, open_source

WIDTH, HEIGHT = 64, 48  # [px]
LOSSY = 6  # error of a grey value after the compression of a video


def plain(value, width=WIDTH, height=HEIGHT):
    return np.full((height, width, 3), value, np.uint8)


def put(folder, name, value, **size):
    assert cv2.imwrite(str(folder / name), plain(value, **size))


def video(path, values):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*'MJPG'), 20.0, (WIDTH, HEIGHT))
    for value in values:
        writer.write(plain(value))
    writer.release()


@pytest.fixture
def warnings():
    return []


@pytest.fixture
def opened(warnings):
    """Return a function that opens a source."""
    return lambda path, **settings: open_source(str(path), Settings(**settings), warnings.append)


def values(source, number):
    """Return the grey values of the next pictures."""
    found = []
    for _ in range(number):
        source.grab()
        picture = source.retrieve()
        assert picture.shape == (*source.size[::-1], 3) and picture.dtype == np.uint8
        found.append(int(picture[0, 0, 0]))
    return found


def refusal(opened, path):
    with pytest.raises(SourceError) as error:
        opened(path)
    return str(error.value)


def test_folder_in_natural_order_round_after_round(opened, tmp_path, warnings):
    for name, value in (('f10.png', 30), ('f2.png', 20), ('f1.PNG', 10), ('f3.bmp', 25)):
        put(tmp_path, name, value)
    (tmp_path / 'camera.yaml').write_text('beside')
    source = opened(tmp_path, framerate=7)
    assert (source.live, source.size, source.rate, source.folder) == (False, (WIDTH, HEIGHT), 7, str(tmp_path))
    assert values(source, 9) == [10, 20, 25, 30, 10, 20, 25, 30, 10]
    assert warnings == [] and source.age() == 0.0


def test_rate_beats_framerate_and_a_videos_own(opened, tmp_path):
    put(tmp_path, 'a.png', 1)
    video(tmp_path / 'v.avi', [1, 2])
    assert [opened(tmp_path, rate=2.5).rate, opened(tmp_path / 'v.avi', rate=2.5).rate] == [2.5, 2.5]
    assert [opened(tmp_path, framerate=9).rate, opened(tmp_path / 'v.avi', framerate=9).rate] == [9, 20.0]


def test_folder_is_listed_anew_for_each_round(opened, tmp_path):
    put(tmp_path, 'a.png', 1)
    source = opened(tmp_path)
    assert values(source, 1) == [1]
    put(tmp_path, 'b.png', 2)
    os.remove(tmp_path / 'a.png')
    assert values(source, 2) == [2, 2]
    put(tmp_path, 'b.png', 3, width=32)  # a new round may have another size
    assert values(source, 1) == [3] and source.size == (32, HEIGHT)
    os.remove(tmp_path / 'b.png')
    with pytest.raises(SourceError, match='contains no images; their names end in .bmp, '):
        source.grab()
    os.rmdir(tmp_path)
    with pytest.raises(SourceError, match='contains no images|No such file'):
        source.grab()


def test_what_does_not_fit_is_named_once_and_left_out(opened, tmp_path, warnings):
    for name, value in (('a.png', 1), ('c.png', 3), ('e.png', 5)):
        put(tmp_path, name, value)
    put(tmp_path, 'b.png', 2, width=80)
    whole = (tmp_path / 'c.png').read_bytes()
    (tmp_path / 'c.png').write_bytes(whole[:len(whole) // 2])
    put(tmp_path, 'd.jpg', 4)
    (tmp_path / 'd.jpg').write_bytes((tmp_path / 'd.jpg').read_bytes()[:-2])
    (tmp_path / 'dd.tif').write_text('no picture')
    (tmp_path / 'f.png').touch()
    source = opened(tmp_path)
    assert values(source, 5) == [1, 5, 1, 5, 1]
    assert len(warnings) == 5
    for warning, (name, said) in zip(warnings, (('b.png', 'it has 80x48 pixels, the first image 64x48'),
                                                ('c.png', 'cut off'), ('d.jpg', 'cut off'), ('dd.tif', 'not an image'),
                                                ('f.png', 'is empty'))):
        assert f'{tmp_path}/{name} is skipped: ' in warning and said in warning
    (tmp_path / 'c.png').write_bytes(whole)  # put right
    assert values(source, 4) == [3, 5, 1, 3]


@pytest.mark.parametrize('name, content, said', [
    ('a.png', b'\x89PNG\r\n', 'none of the 1 images can be read'), ('a.txt', b'x', 'contains no images'),
    (None, b'', 'contains no images'),
])
def test_folder_without_pictures(opened, tmp_path, name, content, said):
    if name:
        (tmp_path / name).write_bytes(content)
    text = refusal(opened, tmp_path)
    assert str(tmp_path) in text and said in text


def test_one_picture(opened, tmp_path):
    put(tmp_path, 'tag.png', 7)
    put(tmp_path, 'other.png', 8)
    source = opened(tmp_path / 'tag.png')
    assert values(source, 3) == [7, 7, 7] and source.folder == str(tmp_path)


def test_pictures_of_other_kinds_become_8_bit_colour(opened, tmp_path):
    cv2.imwrite(str(tmp_path / 'a.png'), np.full((HEIGHT, WIDTH), 40 * 257, np.uint16))
    cv2.imwrite(str(tmp_path / 'b.png'), np.full((HEIGHT, WIDTH, 4), 50, np.uint8))
    cv2.imwrite(str(tmp_path / 'c.pgm'), np.full((HEIGHT, WIDTH), 60, np.uint8))
    assert values(opened(tmp_path), 3) == [40, 50, 60]


def test_video_and_again(opened, tmp_path, warnings):
    video(tmp_path / 'v.avi', [40, 120, 200])
    source = opened(tmp_path / 'v.avi')
    assert (source.live, source.size, source.rate, source.folder) == (False, (WIDTH, HEIGHT), 20.0, str(tmp_path))
    assert values(source, 7) == pytest.approx([40, 120, 200, 40, 120, 200, 40], abs=LOSSY)
    assert warnings == []
    source.close()


def test_without_loop_the_end_is_the_end(opened, tmp_path):
    video(tmp_path / 'v.avi', [40, 120])
    put(tmp_path, 'a.png', 40)
    put(tmp_path, 'b.png', 120)
    for path in (tmp_path, tmp_path / 'v.avi'):
        source = opened(path, loop=False)
        assert values(source, 2) == pytest.approx([40, 120], abs=LOSSY)
        with pytest.raises(EndOfSource):
            source.grab()


def test_a_video_that_says_it_is_longer_is_named(opened, tmp_path, warnings):
    path = tmp_path / 'v.mkv'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*'FFV1'), 20.0, (WIDTH, HEIGHT))
    for value in range(10):
        writer.write(plain(value))
    writer.release()
    whole = path.read_bytes()
    path.write_bytes(whole[:len(whole) // 2])
    source = opened(path, loop=False)
    with pytest.raises(EndOfSource):
        values(source, 10)
    assert len(warnings) == 1 and 'of 10 images: is it complete?' in warnings[0]


@pytest.mark.parametrize('content, said', [
    (b'', 'v.mp4: the file is empty'), (b'text' * 99, 'v.mp4: not a readable video')])
def test_what_is_no_video(opened, tmp_path, content, said):
    (tmp_path / 'v.mp4').write_bytes(content)
    assert said in refusal(opened, tmp_path / 'v.mp4')


def test_what_is_not_there(opened):
    assert '/no/such.mp4: No such file or directory. ' in refusal(opened, '/no/such.mp4')
    assert '/dev/video987: No such file or directory. ' in refusal(opened, '/dev/video987')
    assert '/dev/null is not a camera. ' in refusal(opened, '/dev/null')  # by OpenCV itself
    assert 'video_device is empty' in refusal(opened, '')


def test_pipes_and_folders_that_call_themselves_pictures_are_not_waited_for(opened, tmp_path, warnings):
    os.mkfifo(tmp_path / 'a.png')
    os.mkdir(tmp_path / 'b.png')
    assert 'a.png is neither a device nor a file nor a folder' in refusal(opened, tmp_path / 'a.png')
    assert 'none of the 2 images' in refusal(opened, tmp_path)
    assert [warning.endswith('.png is skipped: it is not a file.') for warning in warnings] == [True, True]


class Recording:
    """cv2.VideoCapture of a webcam with one picture size and format, which has no focus; it can be pulled out."""

    def __init__(self, size=(WIDTH, HEIGHT), fourcc='MJPG', opens=True, stamped=0.0, rate=30.0, broken=()):
        self.size, self.fourcc, self.opens, self.pulled = size, cv2.VideoWriter_fourcc(*fourcc), opens, False
        self.stamped = stamped  # [s] the driver's time stamp is so long ago; None: it has none
        self.rate, self.broken = rate, broken  # broken: the numbers of the grabs
        self.sets, self.number, self.released, self.asked = [], 0, False, None

    def __call__(self, *asked):
        self.asked = asked
        return self

    def isOpened(self):
        return self.opens

    def set(self, prop, value):
        self.sets.append((prop, value))
        return prop != cv2.CAP_PROP_FOCUS

    def get(self, prop):
        if prop == cv2.CAP_PROP_FOURCC:
            return float(self.fourcc)
        if prop in (cv2.CAP_PROP_FPS, cv2.CAP_PROP_FRAME_HEIGHT):
            return self.rate if prop == cv2.CAP_PROP_FPS else float(self.size[1])
        assert prop == cv2.CAP_PROP_POS_MSEC
        return 0.0 if self.stamped is None else (time.monotonic() - self.stamped) * 1000.0

    def grab(self):
        self.number += 1
        self.grabbed = not self.pulled
        return self.grabbed

    def retrieve(self):
        assert self.grabbed, 'OpenCV crashes when a picture is retrieved twice'
        self.grabbed = False
        picture = plain(self.number, *self.size)
        if self.number in self.broken and self.number % 2:
            raise cv2.error('a picture that cannot be')
        return True, None if self.number in self.broken else self.form(picture)

    def form(self, picture):
        return picture

    def release(self):
        self.released = True


def webcam(warnings, recording, **settings):
    asked = Settings(**{'width': WIDTH, 'height': HEIGHT, **settings})
    return open_source('/dev/zero', asked, warnings.append, recording)


def test_webcam_is_asked_for_what_was_set_in_the_order_that_v4l2_needs(warnings):
    recording = Recording(fourcc='YUYV', rate=15.0)
    source = webcam(warnings, recording, framerate=15, pixel_format='yuyv',
                    controls=[('gain', cv2.CAP_PROP_GAIN, 7), ('focus', cv2.CAP_PROP_FOCUS, 5)])
    assert recording.asked == ('/dev/zero', cv2.CAP_V4L2)
    assert recording.sets == [
        (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*'YUYV')), (cv2.CAP_PROP_FRAME_WIDTH, WIDTH),
        (cv2.CAP_PROP_FRAME_HEIGHT, HEIGHT), (cv2.CAP_PROP_FPS, 15), (cv2.CAP_PROP_GAIN, 7), (cv2.CAP_PROP_FOCUS, 5)]
    assert (source.live, source.size, source.folder) == (True, (WIDTH, HEIGHT), None)
    assert warnings == ['/dev/zero rejects focus=5; v4l2-ctl --list-ctrls shows what it accepts.']
    assert values(source, 3) == [2, 3, 4]
    source.close()
    assert recording.released


def test_webcam_that_gives_something_else_is_used_and_named(warnings):
    source = webcam(warnings, Recording(size=(32, 24), fourcc='YUYV', rate=7.5))
    assert source.size == (32, 24) and values(source, 1) == [2]
    assert warnings == ['/dev/zero does not offer 64x48 pixels (it delivers 32x24), the pixel_format mjpeg (it '
                        'delivers YUYV), 30 images per second (it delivers 7.5).']


def test_broken_pictures_of_a_webcam_are_none_and_too_many_are_trouble(warnings):
    source = webcam(warnings, Recording(broken=(1, 2, 4)))  # 3 is the first whole one
    source.grab()
    assert source.retrieve() is None and source.size == (WIDTH, HEIGHT)
    assert values(source, 1) == [5]
    recording = Recording(broken=range(100))
    with pytest.raises(SourceError, match='cannot be decoded; try another pixel_format'):
        webcam(warnings, recording)
    assert recording.released


@pytest.mark.parametrize('form', [lambda picture: picture.reshape(1, -1), lambda picture: picture[:, :, 0]])
def test_webcam_pictures_in_one_row_or_without_colour(warnings, form):
    recording = Recording()
    recording.form = form
    source = webcam(warnings, recording)
    assert source.size == (WIDTH, HEIGHT) and values(source, 2) == [2, 3]


@pytest.mark.parametrize('stamped, age', [(0.05, 0.05), (0.0, 0.0), (None, 0.0), (5.0, 0.0), (-3.0, 0.0)])
def test_age_is_by_the_drivers_stamp_where_it_makes_sense(warnings, stamped, age):
    source = webcam(warnings, Recording(stamped=stamped))
    source.grab()
    assert source.age() == pytest.approx(age, abs=0.04)  # 40 ms for a busy machine


def test_webcam_that_does_not_open_or_is_pulled_out_is_explained_and_let_go(warnings):
    for recording in (Recording(opens=False), Recording()):
        recording.pulled = recording.opens
        with pytest.raises(SourceError, match='/dev/zero is not a camera. '):
            webcam(warnings, recording)
        assert recording.released
    recording = Recording()
    source = webcam(warnings, recording)
    recording.pulled = True
    with pytest.raises(SourceError, match='/dev/zero is not a camera'):
        source.grab()
