# expected: failed: of the way lies on a triangle
../robot_circle/right_timed.py
