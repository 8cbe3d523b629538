"""Read the documentation of nodes: a section with the heading ### SCRIPT, with tables of parameters and names."""
import pathlib
import re

REPOSITORY = pathlib.Path(__file__).resolve().parents[4]
PARAMETER_COLUMNS = ['parameter', 'type', 'default', 'range', 'meaning']
NAME_COLUMNS = ['name', 'kind', 'type', 'meaning']
PAGES = {REPOSITORY: REPOSITORY / 'docs' / 'nodes.md',
         **{path.parent: path for path in sorted(REPOSITORY.glob('packages/**/README.md'))}}  # by the folder


def sections(page):
    """Return {heading: text below it} of the headings ### of a page's text."""
    return dict(re.findall(r'^### (\S+)\n(.*?)(?=^#{1,3} |\Z)', page, re.MULTILINE | re.DOTALL))


def table(text, columns):
    """Return the rows of the tables with these columns, each as {column: cell}."""
    rows, inside = [], False
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip('|').split('|')] if line.startswith('|') else []
        if inside and cells and not set(line) <= set('|-: '):
            rows.append(dict(zip(columns, cells)))
        inside = bool(cells) and (inside or cells == columns)
    return rows


def names(text):
    """Return {(name, kind, type)} of the tables of topics and services in a section."""
    return {(row['name'].strip('`'), row['kind'], row['type']) for row in table(text, NAME_COLUMNS)}


def page_path(script):
    """Return the page that describes a script: that of its package, or of several packages together."""
    package = script.parents[1]
    return PAGES.get(package) or PAGES[package.parent]


def page_of(script):
    return page_path(script).read_text(encoding='utf-8')
