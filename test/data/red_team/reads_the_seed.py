#!/usr/bin/env python3
# expected: failed
# exercise: print_marker_ids
# kind: reads secrets
"""Looks in all command lines and environments for the seed, from which the markers that are shown follow."""
import glob
import re

import rospy

for kind in 'cmdline', 'environ':
    for path in glob.glob(f'/proc/[0-9]*/{kind}'):
        try:
            with open(path, 'rb') as file:
                text = file.read()
        except OSError:
            continue
        for found in re.findall(rb'seed\W+(\d+)', text, re.IGNORECASE):
            print('FOUND seed', int(found), flush=True)
rospy.init_node('seed')
rospy.spin()
