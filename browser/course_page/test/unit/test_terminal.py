"""course_page.terminal: the page and JupyterLab start and end together, and only the address is printed."""
import json
import sys

import pytest

from course_page import terminal
from course_page.panels import RunningPage

LAB = '''#!{python}
import json, os, sys
folder = os.environ['JUPYTER_CONFIG_DIR']
print('[I] log', json.load(open(folder + '/jupyter_server_config.json')), sys.argv[1:])
print('[I] log', json.load(open(folder + '/labconfig/page_config.json')))
{then}
'''


def run(tmp_path, monkeypatch, then):
    """Run main with a program in place of JupyterLab, while a page runs already."""
    program = tmp_path / 'jupyter'
    program.write_text(LAB.format(python=sys.executable, then=then))
    program.chmod(0o755)
    monkeypatch.setattr(terminal, 'running_page', lambda: RunningPage('http://localhost:8123/', '/browser'))
    monkeypatch.setattr(sys, 'argv', ['terminal', str(program), '--folder', str(tmp_path), '--ip=0.0.0.0'])
    monkeypatch.setattr(terminal, 'make_interruptible', lambda: None)
    terminal.main()


def test_the_address_is_told(tmp_path, monkeypatch, capsys):
    run(tmp_path, monkeypatch, 'print("http://localhost:8888/lab?token=5f", flush=True); import time; time.sleep(1)')
    assert capsys.readouterr().out.startswith('Open http://localhost:8888/lab?token=5f in a browser')


def test_what_ends_it_is_shown_with_the_settings(tmp_path, monkeypatch):
    with pytest.raises(SystemExit) as ended:
        run(tmp_path, monkeypatch, 'sys.exit("no port is free")')
    said = str(ended.value)
    assert 'no port is free' in said and "'port': 8123" in said and '--ip=0.0.0.0' in said
    assert f'--ServerApp.root_dir={tmp_path}' in said
    assert "{'@jupyterlab/apputils-extension:announcements': True}" in said  # no question about Jupyter's news


def test_settings_are_json(tmp_path):
    jupyter = tmp_path / 'terminal' / 'bin' / 'jupyter'
    settings = json.loads(json.dumps(terminal.configuration(8123, str(jupyter))))
    page = settings['ServerProxy']['servers']['turtle_robotont']
    assert settings['ServerApp']['terminado_settings'] == {'shell_command': ['bash']}  # no workspace of ./run
    (tmp_path / 'shell.bash').write_text('')
    shell = terminal.configuration(8123, str(jupyter))['ServerApp']['terminado_settings']['shell_command']
    assert shell == ['bash', '--rcfile', str(tmp_path / 'shell.bash'), '-i']
    assert (page['port'], page['command'], page['new_browser_tab']) == (8123, [], False)
