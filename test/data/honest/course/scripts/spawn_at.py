#!/usr/bin/env python3
import os
import sys

import rospkg
import rospy
from turtlesim.srv import Spawn

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path('course'), 'src'))
from course_tools import places  # noqa: E402

rospy.init_node('spawn_at')
rospy.wait_for_service('spawn')
answer = rospy.ServiceProxy('spawn', Spawn)(*places.pose(rospy.get_param('~pose')), rospy.get_param('/turtle'))
rospy.loginfo('the name is %s', answer.name)
