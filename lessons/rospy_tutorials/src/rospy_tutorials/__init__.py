"""Small programs, one for each part of rospy; this module is what two of them share."""
