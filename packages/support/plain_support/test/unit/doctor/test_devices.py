"""doctor.devices: which there are, why one cannot be used; with folders that look like /dev, /sys and /proc."""
import errno
import getpass
import os

import pytest

from plain_support.doctor import devices


@pytest.fixture
def machine(tmp_path):
    """A machine with two cameras and a device without a name, one of the cameras in use by a program."""
    for path, text in (('dev/video0', ''), ('dev/video10', ''), ('dev/video2', ''), ('dev/video', ''), ('dev/null', ''),
                       ('sys/video0/name', 'HD Webcam: HD\n'), ('sys/video10/name', 'Depth\n'),
                       ('proc/4711/comm', 'cheese\n'), (f'proc/{os.getpid()}/comm', 'self\n')):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    for pid in (4711, os.getpid()):
        (tmp_path / f'proc/{pid}/fd').mkdir()
        (tmp_path / f'proc/{pid}/fd/3').symlink_to(tmp_path / 'dev/video0')
    return tmp_path


def test_devices_in_their_natural_order_with_names(machine):
    dev = str(machine / 'dev')
    found = devices.devices(dev, str(machine / 'sys'))
    assert found == [(f'{dev}/video0', 'HD Webcam: HD'), (f'{dev}/video2', ''), (f'{dev}/video10', 'Depth')]
    assert devices.listing(dev, str(machine / 'sys')) == (
        f'Available cameras: {dev}/video0 (HD Webcam: HD), {dev}/video2, {dev}/video10 (Depth).')


def test_no_device(tmp_path):
    assert 'there is no /dev/video*. A video file or a folder' in devices.listing(str(tmp_path), str(tmp_path))


def test_a_busy_device_names_who_has_it(machine):
    text = devices.explain(str(machine / 'dev/video0'), str(machine / 'proc'))
    assert 'video0 is in use by cheese (process 4711): stop it, or choose another camera.' in text


def test_a_device_that_nobody_else_has(machine):
    text = devices.explain(str(machine / 'dev/video2'), str(machine / 'proc'))
    assert 'video2 delivers no images: it is busy, ' in text


@pytest.mark.parametrize('error, said', [
    (errno.ENODEV, 'No such device. '), (errno.EBUSY, 'is in use by cheese (process 4711)'),
    (errno.EACCES, f'permission denied. You ({getpass.getuser()}) must be in the group '),
])
def test_errors_of_opening(machine, monkeypatch, error, said):
    def refuse(*_):
        raise OSError(error, os.strerror(error))
    monkeypatch.setattr(devices.os, 'open', refuse)
    text = devices.explain(str(machine / 'dev/video0'), str(machine / 'proc'))
    assert said in text
    assert error != errno.EACCES or f'sudo usermod -aG {devices.grp.getgrgid(os.getgid()).gr_name} ' in text


def test_a_missing_device_is_a_device_and_a_missing_file_is_none():
    assert devices.is_device('/dev/video99') and devices.is_device('/dev/null')
    assert not devices.is_device('/no/video.mp4') and not devices.is_device(__file__)
