"""Run a peer's detector on numpy images, for peers: peer_detections.py PEER FOLDER COUNT OUT.json.

It runs in the peers' own virtual environment, so it imports nothing of this project. Corners are top left, top right,
bottom right, bottom left of the tag as drawn, in pixels whose centres are whole numbers; each image also has the CPU
time of all threads [ms].
"""
import json
import sys
import time

import numpy as np


def _napa():
    from napa_vision import NapaDetector
    detector = NapaDetector(family='tag36h11', min_tag_px=16)
    return lambda image: [(each.tag_id, np.asarray(each.corners)) for each in detector.detect(image)]


def _locus():
    import locus
    detector = locus.Detector(families=[locus.TagFamily.AprilTag36h11])

    def detect(image):
        batch = detector.detect(image)
        return [(int(number), np.asarray(corners) - 0.5) for number, corners in zip(batch.ids, batch.corners)]
    return detect


def _pupil():
    import pupil_apriltags
    detector = pupil_apriltags.Detector(families='tag36h11', quad_decimate=1.0, nthreads=1)
    return lambda image: [(each.tag_id, np.asarray(each.corners)[[1, 0, 3, 2]] - 0.5)
                          for each in detector.detect(image)]


def main(peer, folder, count, out):
    detect = {'napa-vision': _napa, 'locus-tag': _locus, 'pupil-apriltags': _pupil}[peer]()
    found = []
    for place in range(int(count)):
        image = np.load(f'{folder}/{place}.npy')
        begun = time.process_time()
        seen = detect(image)
        found.append([[[int(number), np.asarray(corners, float).tolist()] for number, corners in seen],
                      1e3 * (time.process_time() - begun)])
    with open(out, 'w', encoding='utf-8') as file:
        json.dump(found, file)


if __name__ == '__main__':
    main(*sys.argv[1:])
