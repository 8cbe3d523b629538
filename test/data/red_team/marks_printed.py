#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: forges results
"""Prints what the systems of teachers take for results."""
print('Grade :=>> 100')
print('::set-output name=score::100')
print('{"scores": {"stop_at_x": 100}}')
print('<|--\nComment :=>> well done\n--|>')
print('<?xml version="1.0"?><testsuites><testsuite failures="0"/></testsuites>')
