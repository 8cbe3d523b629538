#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: prints what terminals obey
"""Ends with an exception whose text, which hints quote, has what a terminal obeys, and marks of CI."""
import rospy

rospy.init_node('escapes')
rospy.logerr('\x1b]52;c;Y2F0\x07\u202e')
raise NameError("name '\x1b[2J\x9b31m\n::error::\nGrade :=>> 100\n' is not defined")
