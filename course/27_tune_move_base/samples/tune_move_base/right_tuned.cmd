rosrun dynamic_reconfigure dynparam load /move_base/TrajectoryPlannerROS values/tuned.yaml
