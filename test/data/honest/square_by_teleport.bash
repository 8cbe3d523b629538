#!/bin/bash
rosservice call /turtle1/teleport_absolute 2.0 2.0 0.0
rosservice call /turtle1/teleport_absolute 8.0 2.0 1.57
rosservice call /turtle1/teleport_absolute 8.0 8.0 3.14
rosservice call /turtle1/teleport_absolute 2.0 8.0 4.71
rosservice call /turtle1/teleport_absolute 2.0 2.0 0.0
