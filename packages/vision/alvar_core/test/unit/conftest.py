"""One thread, so that runs repeat and times compare."""

import cv2

cv2.setNumThreads(1)
