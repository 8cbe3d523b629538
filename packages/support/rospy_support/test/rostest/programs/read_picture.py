"""Pattern of the first OpenCV lessons: no ROS at all; a picture is shown until a key is pressed."""
import sys

import cv2

image = cv2.imread(sys.argv[1], cv2.IMREAD_COLOR)
cv2.imshow('Image', image)
code = cv2.waitKey(0)
cv2.destroyAllWindows()
print('code', code)
