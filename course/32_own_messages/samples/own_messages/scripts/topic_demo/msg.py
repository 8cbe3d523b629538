"""The message of ../../msg."""
import pathlib

from genpy.dynamic import generate_dynamic

_FILE = pathlib.Path(__file__).resolve().parents[2] / 'msg' / 'Person.msg'
Person = generate_dynamic('topic_demo/Person', _FILE.read_text())['topic_demo/Person']
