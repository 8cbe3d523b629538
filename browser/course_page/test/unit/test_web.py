"""The page in web/: small, complete without the internet, and free of HTML made from texts."""
import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
WEB = REPOSITORY / 'browser' / 'course_page' / 'web'
FILES = sorted(path for path in WEB.rglob('*') if path.is_file())
OWN = [path for path in FILES if path.suffix in ('.js', '.css', '.html') and 'vendor' not in path.parts]
LARGEST = 500_000  # [B] of all files of the page
NAMESPACE = 'http://www.w3.org/2000/svg'


def each(paths):
    return pytest.mark.parametrize('path', paths, ids=lambda path: str(path.relative_to(WEB)))


def test_the_page_is_small():
    assert sum(path.stat().st_size for path in FILES) < LARGEST


@each(OWN)
def test_nothing_comes_from_elsewhere(path):
    code = re.sub(r'(?m)(^|\s)//\s.*', '', path.read_text('utf-8'))
    addresses = re.findall(r'(?:https?:)?//[\w.-]+\.\w+[^\s\'"]*', code)
    assert set(addresses) <= {NAMESPACE}


@each([path for path in OWN if path.suffix == '.js'])
def test_texts_never_become_html(path):
    forbidden = r'innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function'
    assert re.findall(forbidden, path.read_text('utf-8')) == []


@each([path for path in OWN if path.suffix == '.html'])
def test_nothing_is_inline(path):
    text = path.read_text('utf-8')
    assert re.findall(r'<style|\sstyle=|\son\w+=', text) == []
    assert re.findall(r'<script(?![^>]*\ssrc=)', text) == []


@each([path for path in OWN if path.suffix == '.js'])
def test_what_a_module_imports_is_there(path):
    names = re.findall(r'(?:from|import)\s*\(?\s*[\'"](\.[^\'"]+)[\'"]', path.read_text('utf-8'))
    assert [name for name in names if not (path.parent / name).is_file()] == []


def test_every_panel_is_in_the_menu():
    listed = re.findall(r"import\('\.\./panels/([\w.-]+)'\)", (WEB / 'app' / 'panels.js').read_text('utf-8'))
    assert sorted(listed) == sorted(path.name for path in (WEB / 'panels').glob('*.js'))
