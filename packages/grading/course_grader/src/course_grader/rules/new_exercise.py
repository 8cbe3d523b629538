"""The exercise file that ./run grade --new writes: one that works, with comments to change it by."""
TEXT = '''\
# An exercise. Grade a program by it: ./run grade THIS_FILE -- PROGRAM
# ./run grade --checks lists all keys, checks and stimuli. A quantity needs a unit: 40 s, 0.5 m/s, 90 deg, 10 Hz.

title: Drive two meters and stop  # one line

# The task, as the students read it: what to do, and every limit that counts.
asks: >
  Write a node that subscribes to /turtle1/pose, publishes on /turtle1/cmd_vel, drives at least two meters, and stops
  the turtle at x = 9. You have 30 s.

simulator: turtlesim  # or robotont
time: 30 s  # of simulated time; a program that is done earlier is graded earlier
pass: 80  # the score from 0 to 100 that passes

# Values that differ from student to student. Their names draw them; $goal stands for this one in all texts:
# vary: {goal: 8 to 10 m}

# Where the turtle starts. Each grading draws it from these spans, so that no program can know it.
start: {x: 3 to 5 m, y: 2 to 9 m, theta: 0 deg}
# How often a program is graded, each time with other values, if one of them could be guessed. All have to pass.
# starts: 2

# Instead of it, several Robotonts with their starts; a check says which one it judges, by robot: robot2.
# robots: {robot1: {x: 0 m, y: 0 m}, robot2: {x: 2 m, y: -0.2 to 0.2 m}}

# What stands around the Robotont, as in the world files of robotont_gazebo:
# world:
#   boxes: [{name: box, x: 2.4, y: 0.0, yaw: 0.0, length: 1.0, width: 1.0, height: 1.0, colour: grey}]
# By how much all this is shifted with each seed, so that a program has to look where it is:
# shift: {y: -0.3 to 0.3 m}
# Nodes that run beside the simulator of the Robotont, as for navigation:
# beside: [map_server, amcl]
# odometry: {noise: 20 mm}  # of that robot; 0 by default
# parameters: {/move_base/recovery_behavior_enabled: false}  # instead of those in the launch files of these nodes
# localised: true  # amcl knows where the robot starts
# unmapped: [box]  # names of what is not on the map of map_server

# Shortcuts that are allowed: teleport, reset, kill. By default none is.
allows: []

# What the grader does while the program runs. This one would call a service of the program:
# stimuli:
#   - {do: call, service: /go, type: turtlesim/TeleportAbsolute, request: [2 to 9 m, 2 to 9 m, 0 to 90 deg], times: 3}

# What counts. The points add up to 100. Below half of the points of a check with "must: true" the exercise fails.
# With "visible: after the deadline" or "visible: never" students do not see a check in their results.
checks:
  - {check: moves, points: 20, length: 2 m}
  - {check: stops, points: 60, must: true, x: 9 m, tolerance: 0.15 m, size: 1 m}
  - {check: connects, points: 20, topic: /turtle1/pose, role: subscribes}

# A program that does what is asked, for {check: same_path}: students have to drive as it does from the same start.
# solution: |
#   import rospy
#   ...

# Advice for mistakes of this exercise. All that is given has to hold:
symptoms:
  - {lost: stops, linear: at most -0.01 m/s, hint: a negative linear.x drives backward}
'''
