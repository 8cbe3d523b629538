# expected: failed: of the way lies on a circle
../robot_square/right_odometry.py
