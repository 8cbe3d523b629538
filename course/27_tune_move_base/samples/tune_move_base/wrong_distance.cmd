# expected: failed: of 3 reached
rosrun dynamic_reconfigure dynparam load /move_base/TrajectoryPlannerROS values/far.yaml
