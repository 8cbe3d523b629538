"""One thread, so that runs repeat and times compare; the scenes and the score of the bench."""

import cv2

cv2.setNumThreads(1)
