"""The service of ../../srv."""
import pathlib

from genpy.dynamic import generate_dynamic

_FILE = pathlib.Path(__file__).resolve().parents[2] / 'srv' / 'Greet.srv'
_REQUEST, _RESPONSE = _FILE.read_text().split('---\n')
GreetRequest = generate_dynamic('topic_demo/GreetRequest', _REQUEST)['topic_demo/GreetRequest']
GreetResponse = generate_dynamic('topic_demo/GreetResponse', _RESPONSE)['topic_demo/GreetResponse']


class Greet:
    _type, _md5sum = 'topic_demo/Greet', '*'
    _request_class, _response_class = GreetRequest, GreetResponse
