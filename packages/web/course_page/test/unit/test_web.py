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
    assert circle({path: imports_of(path) for path in MODULES}) == []


def test_the_shell_loads_all_panels():
    assert set((WEB / 'panels').glob('*.js')) < set(imports_of(WEB / 'app' / 'shell.js'))


def test_a_circle_is_found():
    assert circle({'a': ['b', 'c'], 'b': ['c'], 'c': []}) == []
    assert circle({'a': ['b'], 'b': ['c', 'd'], 'c': [], 'd': ['b']}) == ['b', 'd', 'b']


def imports_of(path):
    """Return the modules that a module imports; a name computed by ${...} stands for every file that it matches."""
    names = re.findall(r'(?:from|import)\s*\(?\s*[\'"`](\.[^\'"`]+)[\'"`]', path.read_text('utf-8'))
    found = []
    for name in names:
        folder, pattern = (path.parent / name).parent.resolve(), re.sub(r'\$\{[^}]*\}', '*', pathlib.Path(name).name)
        found += sorted(folder.glob(pattern)) or [folder / pattern]
    return found


def circle(graph):
    """Return the names of a circle in {name: those that it imports}, [] if there is none."""
    done = set()

    def search(name, way):
        if name in way:
            return [*way[way.index(name):], name]
        found = [] if name in done else first(search(one, [*way, name]) for one in graph.get(name, ()))
        done.add(name)
        return found

    def first(circles):
        return next(filter(None, circles), [])
    return first(search(name, []) for name in graph)


def test_every_panel_is_in_the_menu():
    listed = re.findall(r"\{id: '(\w+)'", (WEB / 'app' / 'panels.js').read_text('utf-8'))
    assert sorted(listed) == sorted(path.stem for path in (WEB / 'panels').glob('*.js'))
