"""Fills in the templates of pages and pictures: the HTML, CSS, JavaScript and SVG files in the folder ``templates``.

All values are escaped, because names, reasons and printed lines are a student's.
"""
import pathlib
from typing import Any

import jinja2

from course_grader.formats import harmless

FOLDER = pathlib.Path(__file__).parents[1] / 'templates'


def _finalized(value: object) -> object:
    """Return a value to insert, with ``?`` for characters that a page cannot hold; markup stays as it is."""
    return harmless.plain(value) if isinstance(value, str) and not hasattr(value, '__html__') else value


ENVIRONMENT = jinja2.Environment(loader=jinja2.FileSystemLoader(str(FOLDER)), autoescape=True, finalize=_finalized,
                                 undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def rendered(name: str, **values: Any) -> str:
    return ENVIRONMENT.get_template(name).render(values)


def verbatim(name: str) -> str:
    """Return the text of a file in the folder that is not a template."""
    return (FOLDER / name).read_text(encoding='utf-8')
