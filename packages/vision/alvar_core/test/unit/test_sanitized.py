"""The compiled steps stay in their memory: AddressSanitizer and UndefinedBehaviorSanitizer watch them."""
import os
import pathlib
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor

import pytest

from unit_support import REPOSITORY

pytestmark = pytest.mark.slow

NATIVE = pathlib.Path(__file__).resolve().parents[2] / 'native'
FLAGS = ['-std=c++17', '-O1', '-fPIC', '-fvisibility=hidden', '-Wno-psabi', '-fsanitize=address,undefined',
         '-fno-sanitize-recover=undefined']
DETECT = '''
import importlib.util, sys
spec = importlib.util.spec_from_file_location('alvar_core._native', sys.argv[1])
steps = importlib.util.module_from_spec(spec)
sys.modules['alvar_core._native'] = sys.modules['alvar_core._native_avx2'] = steps
spec.loader.exec_module(steps)

import cv2
import numpy as np
from unit_support import marker_classes
from alvar_core import native
from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from alvar_core.camera import FisheyeCamera
from unit_support.photo import with_gamma

assert native.steps is steps
cv2.setNumThreads(1)
rng, found = np.random.default_rng(5), 0
larger, detector = Detector(0.1, resolution=7), Detector(marker_classes.SIZE)
for width, height in (16, 16), (17, 200), (321, 63), (320, 240):
    noise = rng.integers(0, 256, (height, width), np.uint8)
    wide = FisheyeCamera([90.0, 0, width / 2, 0, 90, height / 2, 0, 0, 1], [0.1, 0.01, 0, 0])
    for image in (noise, cv2.GaussianBlur(noise, (9, 9), 0), np.where(noise > 250, noise, 0), noise // 128 * 255):
        for camera in (default_camera(width, height, distorted=True), wide):
            detector.detect(image, camera)
            larger.detect(image, camera)
for name in 'even', 'blinds', 'thin margin', 'bent 6 cm', 'frame edge', 'occluded':
    shot = marker_classes.photo(name, marker_classes.DEVELOPMENT, 0)
    found += len(detector.detect(shot.image, shot.camera))
    for gamma in 1.0, 2.2, None:
        Detector(marker_classes.SIZE, gamma=gamma, max_candidates=1).detect(with_gamma(shot.image, 2.2), shot.camera)
print(found)
'''


@pytest.mark.nightly
def test_no_step_leaves_its_memory(tmp_path):
    compiler, include = os.environ.get('CXX', 'c++'), '-I' + sysconfig.get_paths()['include']

    def built(source):
        target = tmp_path / (source.stem + '.o')
        subprocess.run([compiler, *FLAGS, include, '-c', source, '-o', target], check=True)
        return target
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(built, sorted(NATIVE.glob('*.cpp'))))
    module = tmp_path / '_native.so'
    subprocess.run([compiler, *FLAGS, '-shared', *objects, '-o', module], check=True)
    # where a program's own code is not C++, libasan needs libstdc++ beside it to see exceptions
    preloaded = [subprocess.check_output([compiler, '-print-file-name=' + name], text=True).strip()
                 for name in ('libasan.so', 'libstdc++.so')]
    path = os.pathsep.join([str(REPOSITORY / 'test'), os.environ.get('PYTHONPATH', '')])
    result = subprocess.run([sys.executable, '-c', DETECT, module], capture_output=True, text=True, check=False,
                            timeout=600,
                            env={**os.environ, 'PYTHONPATH': path, 'LD_PRELOAD': ' '.join(preloaded),
                                 'ASAN_OPTIONS': 'detect_leaks=0'})  # Python itself keeps memory until it ends
    assert result.returncode == 0, result.stderr[-4000:]
    assert int(result.stdout) >= 5
