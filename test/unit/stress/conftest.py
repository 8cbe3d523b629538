import os
import sys

for _folder in ('bench', 'stress'):
    sys.path.insert(0, os.path.join(os.path.dirname(__file__), '..', '..', '..', _folder))
