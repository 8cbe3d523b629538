"""Lists the cameras that Linux knows, and explains why one of them cannot be used. Without ROS."""
import errno
import glob
import grp
import os
import re
import stat
from typing import List, Optional, Tuple

from plain_support.doctor.processes import user_name

DEV, SYSFS = '/dev', '/sys/class/video4linux'
VIDEO4LINUX = 81  # major device number


def natural(text: str) -> List[Tuple[bool, int, str]]:
    """Return a sort key that puts video2 before video10."""
    return [(part.isdigit(), int(part) if part.isdigit() else 0, part) for part in re.split(r'(\d+)', text)]


def devices(dev: str = DEV, sysfs: str = SYSFS) -> List[Tuple[str, str]]:
    """Return [(path, the camera's name or '')] of all video devices, in natural order."""
    return [(path, _first_line(f'{sysfs}/{os.path.basename(path)}/name'))
            for path in sorted(glob.glob(f'{dev}/video[0-9]*'), key=natural)]


def listing(dev: str = DEV, sysfs: str = SYSFS) -> str:
    """Return a sentence that names the existing devices."""
    found = [f'{path} ({name})' if name else path for path, name in devices(dev, sysfs)]
    if not found:
        return 'No camera is connected: there is no /dev/video*. A video file or a folder of images works too.'
    return f'Available cameras: {", ".join(found)}.'


def explain(path: str, proc: str = '/proc') -> str:
    """Return why a device that has failed cannot be used as a camera, and what to do about it."""
    return trouble(path, proc) or (f'{path} delivers no images: it is busy, does not capture images, or was just '
                                   f'unplugged. {listing()}')


def trouble(path: str, proc: str = '/proc') -> Optional[str]:
    """Return why a camera cannot be opened, and what to do about it; None if it can."""
    try:
        state = os.stat(path)
        if stat.S_ISCHR(state.st_mode) and os.major(state.st_rdev) != VIDEO4LINUX:
            return f'{path} is not a camera. {listing()}'
        os.close(os.open(path, os.O_RDWR | os.O_NONBLOCK))
        reason = errno.EBUSY if users(path, proc) else 0
    except OSError as error:
        reason = error.errno or 0
    if reason in (errno.EACCES, errno.EPERM):
        return f'{path}: permission denied. {_permission(path)}'
    if reason == errno.EBUSY:
        holders = ', '.join(f'{name} (process {pid})' for pid, name in users(path, proc))
        return f'{path} is in use by {holders or "another program"}: stop it, or choose another camera. {listing()}'
    if reason:
        return f'{path}: {os.strerror(reason)}. {listing()}'
    return None


def users(path: str, proc: str = '/proc') -> List[Tuple[int, str]]:
    """Return [(pid, name)] of the other processes that have the device open, as far as this user may see.

    /proc is read directly, because psutil's open_files() omits devices.
    """
    found = set()
    target = os.path.realpath(path)
    for link in glob.glob(f'{proc}/[0-9]*/fd/*'):
        pid = int(link.split('/')[-3])
        try:
            if pid != os.getpid() and os.readlink(link) == target:
                found.add((pid, _first_line(f'{proc}/{pid}/comm')))
        except OSError:
            pass  # it has just ended, or belongs to another user
    return sorted(found)


def is_device(path: str) -> bool:
    """Return whether a path is a device, or would be one if it existed."""
    try:
        return stat.S_ISCHR(os.stat(path).st_mode)
    except OSError:
        return path.startswith(f'{DEV}/')


def _permission(path: str) -> str:
    user = user_name(os.getuid())
    try:
        group = grp.getgrgid(os.stat(path).st_gid).gr_name
    except (KeyError, OSError):
        group = 'video'
    return (f'You ({user}) must be in the group {group}: run sudo usermod -aG {group} {user}, then log out and in '
            'again.')


def _first_line(path: str) -> str:
    try:
        with open(path, encoding='utf-8', errors='replace') as file:
            return file.readline().strip()
    except OSError:
        return ''
