"""Type hints: the folders that mypy checks, and the reasons for the others."""
import configparser
import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
IGNORED = re.compile(r'#\s*type:\s*ignore.*')
WITH_REASON = re.compile(r'# type: ignore\[[a-z-]+(, [a-z-]+)*\]  # \S.*')


def settings():
    parser = configparser.ConfigParser()
    parser.read(REPOSITORY / 'mypy.ini')
    return parser['mypy']


def checked():
    """Return the paths of the folders and modules that mypy checks."""
    names = [name.strip() for name in settings()['files'].split(',')]
    assert all(any(REPOSITORY.glob(name)) for name in names)
    return [path for name in names for path in sorted(REPOSITORY.glob(name))]


MODULES = [module for path in checked() for module in (sorted(path.rglob('*.py')) if path.is_dir() else [path])]


def ignores_without_reason(source):
    return [found for found in IGNORED.findall(source) if not WITH_REASON.fullmatch(found)]


@pytest.mark.parametrize('source, wrong', [
    ('x = 1', 0), ('x = f()  # type: ignore[no-any-return]  # the stub is wrong', 0),
    ('x = f()  # type: ignore', 1), ('x = f()  # type: ignore[arg-type]', 1), ('x = f()  #type:ignore # why', 1),
])
def test_reason_of_an_ignore_is_seen(source, wrong):
    assert len(ignores_without_reason(source)) == wrong


def test_everything_is_strict():
    assert settings()['strict'] == 'True'
    assert len(MODULES) >= 60


@pytest.mark.parametrize('path', MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_each_ignore_has_its_reason(path):
    assert ignores_without_reason(path.read_text(encoding='utf-8')) == []
