"""course_page.terminal: the page and JupyterLab start and end together, and only the address is printed."""
import json
import sys

import pytest

from course_page import terminal
from course_page.panels import RunningPage
from course_page.typed_paths import below

LAB = '''#!{python}
import json, os, sys
folder = os.environ['JUPYTER_CONFIG_DIR']
print('[I] log', json.load(open(folder + '/jupyter_server_config.json')), sys.argv[1:])
print('[I] log', json.load(open(folder + '/labconfig/page_config.json')))
{then}
'''


def run(tmp_path, monkeypatch, then, *given):
    """Run main with a program in place of JupyterLab, while a page runs already."""
    program = tmp_path / 'jupyter'
    program.write_text(LAB.format(python=sys.executable, then=then))
    program.chmod(0o755)
    monkeypatch.setattr(terminal, 'running_page', lambda: RunningPage('http://localhost:8123/', '/browser'))
    monkeypatch.setenv('HOME', str(tmp_path))
    monkeypatch.setattr(sys, 'argv', ['terminal', str(program), *given, '--ip=0.0.0.0'])
    monkeypatch.setattr(terminal, 'make_interruptible', lambda: None)
    terminal.main()


SERVES = 'print("http://localhost:8888/lab?token=5f", flush=True); import time; time.sleep(1)'
ADDRESS = 'Open http://localhost:8888/lab?token=5f in a browser'


def test_the_address_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run(tmp_path, monkeypatch, SERVES)
    assert capsys.readouterr().out.startswith(ADDRESS)


def test_what_ends_it_is_shown_with_the_settings(tmp_path, monkeypatch):
    with pytest.raises(SystemExit) as ended:
        run(tmp_path, monkeypatch, 'sys.exit("no port is free")', '--folder', str(tmp_path))
    output = str(ended.value)
    assert 'no port is free' in output and "'port': 8123" in output and '--ip=0.0.0.0' in output
    assert f'--ServerApp.root_dir={tmp_path}' in output
    assert "{'@jupyterlab/apputils-extension:announcements': True}" in output  # no question about Jupyter's news


def test_settings_are_json(tmp_path):
    jupyter = tmp_path / 'terminal' / 'bin' / 'jupyter'
    settings = json.loads(json.dumps(terminal.configuration(8123, str(jupyter))))
    page = settings['ServerProxy']['servers']['turtle_robotont']
    assert settings['ServerApp']['terminado_settings'] == {'shell_command': ['bash']}  # no workspace of ./run
    (tmp_path / 'shell.bash').write_text('')
    shell = terminal.configuration(8123, str(jupyter))['ServerApp']['terminado_settings']['shell_command']
    assert shell == ['bash', '--rcfile', str(tmp_path / 'shell.bash'), '-i']
    assert (page['port'], page['command'], page['new_browser_tab']) == (8123, [], False)


def test_home_is_shown_and_opened_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.setenv('HOME', str(tmp_path))
    here = tmp_path / 'a' / 'b'
    assert terminal.shown_folders(None, str(here)) == (str(tmp_path), 'a/b')
    assert terminal.shown_folders(None, str(tmp_path)) == (str(tmp_path), '')
    assert terminal.shown_folders(None, '/opt') == (str(tmp_path), '')  # the user is told
    assert terminal.shown_folders(None, str(tmp_path / '.cache' / 'x')) == (str(tmp_path), '')  # not listed
    assert terminal.shown_folders(str(here), str(tmp_path)) == (str(here), '')
    monkeypatch.setenv('HOME', '/no/such/home')
    assert terminal.shown_folders(None, '/opt') == ('/opt', '')


def test_what_is_shown_instead_of_the_current_folder_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir('/')
    run(tmp_path, monkeypatch, SERVES)
    output = capsys.readouterr().out.splitlines()
    assert output[0].startswith(f'The editor shows {tmp_path} ') and output[0].endswith('--folder /')
    assert output[1].startswith(ADDRESS)
    run(tmp_path, monkeypatch, SERVES, '--folder', '~')  # asked for
    assert capsys.readouterr().out.startswith(ADDRESS)
    with pytest.raises(SystemExit, match='--folder /no/such is not a folder'):
        run(tmp_path, monkeypatch, SERVES, '--folder', '/no/such')


@pytest.mark.parametrize('typed, expected', [
    ('~/ros_ws/src/x.py', 'ros_ws/src/x.py'), ('~', ''), ('~/', ''), ('ros_ws/src/x.py', 'ros_ws/src/x.py'),
    ('HOME/ros_ws/x.py', 'ros_ws/x.py'), ('HOME', ''), ('LINK/ros_ws/x.py', 'ros_ws/x.py'),
    ('etc/x.py', 'etc/x.py'),  # the first slash is lost, so it may be a folder of the root
    ('~ann/x.py', '~ann/x.py'), ('a~/x.py', 'a~/x.py'), ('', '')])
def test_paths_as_typed_in_a_terminal(tmp_path, monkeypatch, typed, expected):
    home, link = tmp_path / 'real', tmp_path / 'link'
    home.mkdir()
    link.symlink_to(home)
    monkeypatch.setenv('HOME', str(link))
    typed = typed.replace('HOME', str(home).strip('/')).replace('LINK', str(link).strip('/'))
    assert below(str(home), typed) == expected


def test_a_folder_of_the_root_that_is_called_as_home_is_kept(tmp_path, monkeypatch):
    monkeypatch.setenv('HOME', str(tmp_path))
    path = f'{str(tmp_path).strip("/")}/x.py'
    (tmp_path / path).parent.mkdir(parents=True)
    assert below(str(tmp_path), path) == path


@pytest.mark.parametrize('typed', ['~/x.py', '~/../x.py'])
def test_paths_outside_of_the_shown_folder_are_refused(tmp_path, monkeypatch, typed):
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    with pytest.raises(ValueError, match='is not below .*shown, the only folder .*: --folder ~ shows your own'):
        below(str(tmp_path / 'shown'), typed)
