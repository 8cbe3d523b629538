"""The page in web/: small, complete without the internet, and free of HTML made from texts."""
import pathlib
import re

import pytest

WEB = pathlib.Path(__file__).resolve().parents[2] / 'web'
FILES = sorted(path for path in WEB.rglob('*') if path.is_file())
OWN = [path for path in FILES if path.suffix in ('.js', '.css', '.html') and 'vendor' not in path.parts]
MODULES = [path for path in OWN if path.suffix == '.js']
LARGEST = 700_000  # [B] of all files of the page
NAMESPACE = 'http://www.w3.org/2000/svg'


def each(paths):
    return pytest.mark.parametrize('path', paths, ids=lambda path: str(path.relative_to(WEB)))


def test_the_page_is_small():
    assert 100_000 < sum(path.stat().st_size for path in FILES) < LARGEST


@each(OWN)
def test_nothing_comes_from_elsewhere(path):
    code = re.sub(r'(?m)(^|\s)//\s.*', '', path.read_text('utf-8'))
    addresses = re.findall(r'(?:https?:)?//[\w.-]+\.\w+[^\s\'"]*', code)
    assert set(addresses) <= {NAMESPACE}


@each(MODULES)
def test_texts_never_become_html(path):
    forbidden = r'innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function'
    assert re.findall(forbidden, path.read_text('utf-8')) == []


@each([path for path in OWN if path.suffix == '.html'])
def test_nothing_is_inline(path):
    text = path.read_text('utf-8')
    assert re.findall(r'<style|\sstyle=|\son\w+=', text) == []
    assert re.findall(r'<script(?![^>]*\ssrc=)', text) == []


@each(MODULES)
def test_imported_modules_exist(path):
    assert [str(imported) for imported in imports_of(path) if not imported.is_file()] == []


def test_modules_import_each_other_in_one_direction():
    left = {path: imports_of(path) for path in MODULES}
    while left:
        ready = [path for path in left if not left.keys() & set(left[path])]
        assert ready, f'among these, modules import each other in a circle: {list(map(str, left))}'
        for path in ready:
            del left[path]


def test_the_shell_loads_all_panels():
    assert set((WEB / 'panels').glob('*.js')) < set(imports_of(WEB / 'app' / 'shell.js'))


def imports_of(path):
    """Return the modules that a module imports; a name computed by ${...} stands for every file that it matches."""
    names = re.findall(r'(?:from|import)\s*\(?\s*[\'"`](\.[^\'"`]+)[\'"`]', path.read_text('utf-8'))
    found = []
    for name in names:
        folder, pattern = (path.parent / name).parent.resolve(), re.sub(r'\$\{[^}]*\}', '*', pathlib.Path(name).name)
        found += sorted(folder.glob(pattern)) or [folder / pattern]
    return found


def test_every_panel_is_in_the_menu():
    listed = re.findall(r"\{id: '(\w+)'", (WEB / 'app' / 'panels.js').read_text('utf-8'))
    assert sorted(listed) == sorted(path.stem for path in (WEB / 'panels').glob('*.js'))
