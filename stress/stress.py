#!/usr/bin/env python3
"""./run stress: see campaign.py."""
import sys

from campaign import main

sys.exit(main())
