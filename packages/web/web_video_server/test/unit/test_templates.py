"""The pages' templates: names of topics are text, in HTML and in addresses."""
from web_video_server.node import TEMPLATES

HOSTILE = '/a"><script>&b'


def test_topics_are_listed_with_links():
    page = TEMPLATES.get_template('index.html').render(topics=['/camera/image_raw', HOSTILE])
    for name in ('stream_viewer', 'stream', 'snapshot'):
        assert f'<a href="/{name}?topic=%2Fcamera%2Fimage_raw">{name}</a>' in page
        assert f'<a href="/{name}?topic=%2Fa%22%3E%3Cscript%3E%26b">{name}</a>' in page
    assert '<script>' not in page and '&lt;script&gt;' in page


def test_an_empty_list_says_what_to_do():
    assert 'No node publishes images. Start a camera' in TEMPLATES.get_template('index.html').render(topics=[])


def test_viewer_shows_the_stream():
    page = TEMPLATES.get_template('viewer.html').render(topic=HOSTILE, query='topic=/a&type=png"><script>')
    assert '<img src="/stream?topic=/a&amp;type=png' in page
    assert '<script>' not in page
