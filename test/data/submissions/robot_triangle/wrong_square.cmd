# expected: failed: of the way lies on a triangle
../robot_square/right_odometry.py
