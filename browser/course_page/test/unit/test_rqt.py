"""The stand-ins for rqt: each folder equals the others except for its name; the name decides which panel opens."""
import pathlib
import sys

import pytest

from course_page import panels

BROWSER = pathlib.Path(__file__).resolve().parents[3]
FOLDERS = sorted(BROWSER.glob('rqt_*'))


def test_every_folder_has_its_panel():
    assert {folder.name for folder in FOLDERS} == {'rqt_gui', *panels.PROGRAMS}


@pytest.mark.parametrize('folder', FOLDERS, ids=lambda folder: folder.name)
def test_folders_differ_in_names_only(folder):
    program = (BROWSER / 'rqt_gui' / 'scripts' / 'rqt').read_text()
    names = ['rqt', 'rqt_gui'] if folder.name == 'rqt_gui' else [folder.name]
    assert sorted(path.name for path in (folder / 'scripts').iterdir()) == names
    assert {path.read_text() for path in (folder / 'scripts').iterdir()} == {program}
    assert (folder / 'setup.py').samefile(BROWSER / 'rqt_gui' / 'setup.py')
    if folder.name != 'rqt_gui':
        assert (folder / 'CMakeLists.txt').read_text() == \
            (BROWSER / 'rqt_graph' / 'CMakeLists.txt').read_text().replace('rqt_graph', folder.name)


@pytest.mark.parametrize('typed, address', [
    ('rqt', '/'), ('rqt_gui', '/'), ('rqt -s rqt_plot', '/plot'), ('rqt --standalone rqt_top/Top', '/nodes'),
    ('rqt_graph', '/graph'), ('rqt_console', '/console'), ('rqt_topic --force-discover', '/topics'),
    ('rqt_image_view', '/image'), ('rqt_image_view /camera/image_raw', '/image?topic=%2Fcamera%2Fimage_raw'),
    ('rqt_plot /a/x /a/y', '/plot?fields=%2Fa%2Fx+%2Fa%2Fy'),
])
def test_the_name_decides(typed, address, monkeypatch):
    shown = []
    monkeypatch.setattr(panels, 'show', shown.append)
    monkeypatch.setattr(sys, 'argv', ['/any/folder/' + typed.split()[0], *typed.split()[1:]])
    panels.main()
    assert shown == [address]


def test_unknown_plug_in_is_named(monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['rqt', '-s', 'rqt_bag'])
    with pytest.raises(SystemExit):
        panels.main()
    assert 'there is no plug-in rqt_bag here; choose from rqt_console' in capsys.readouterr().err
