# expected: failed: |angular.z| 0.00 rad/s
../robot_forward/right_node.py
