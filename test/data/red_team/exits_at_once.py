#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: ends early
"""Ends with success before anything was done."""
import os

os._exit(0)
