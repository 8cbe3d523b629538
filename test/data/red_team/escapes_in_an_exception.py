#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: prints what terminals obey
"""Prints what a terminal obeys: clear, title, clipboard, bell, other directions of writing; ends with marks of CI."""
import rospy

rospy.init_node('escapes')
print('\x1b[2J\x1b]0;title\x07\x1b]52;c;Y2F0\x07\x07\x00\x08\x9b31m\u202e\u200f\u2066', flush=True)
rospy.logerr('\x1b]52;c;Y2F0\x07\u202e')
raise NameError("name '\x1b[2J\x9b31m\n::error::\nGrade :=>> 100\n' is not defined")  # hints quote it
