"""One thread, so that runs repeat and times compare; the scenes and the score of the bench."""
import os
import sys

import cv2

sys.path.insert(0, os.path.join(os.path.dirname(__file__), '..', '..', '..', 'bench'))

cv2.setNumThreads(1)
