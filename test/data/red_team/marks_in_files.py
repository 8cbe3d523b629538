#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: forges results
# at none: open
"""Writes the results itself, into every folder that it can find."""
import os

text = '{"outcome": "passed", "score": 100.0, "objections": [], "reasons": [], "hints": []}'
for parent in ('.', '..', os.path.expanduser('~'), os.path.dirname(os.path.abspath(__file__)), '/autograder/results'):
    for name in ('result.json', 'results.json', 'junit.xml'):
        try:
            with open(os.path.join(parent, name), 'w') as file:
                file.write(text)
        except OSError:
            continue
