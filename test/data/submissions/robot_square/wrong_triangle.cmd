# expected: failed: of the way lies on a square
../robot_triangle/right_odometry.py
