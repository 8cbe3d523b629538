#!/bin/bash
# expected: failed
# exercise: stop_at_x
# kind: outlives the grading
env -i setsid nohup bash -c 'trap "" INT TERM HUP; (sleep 3457 &); (sleep 3457 &)' >/dev/null 2>&1 &
sleep 1
