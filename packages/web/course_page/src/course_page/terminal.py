"""terminal: JupyterLab with the page as one of its tabs. Anyone who has its address has a shell on this machine.

JupyterLab checks the token of its address for all that it serves, so the page behind it listens on 127.0.0.1 only.
"""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shlex
import sys
import tempfile
import time
import urllib.parse
from typing import Any, Dict, List, Optional, Sequence, Tuple

import rospy

from course_page.panels import running_page
from plain_support.processes import BackgroundProcess, make_interruptible
from rospy_support.ports import free_port

PAGE = 'rosrun', 'course_page', 'browser'
TITLE = 'Turtle and Robotont'  # of the page's tab
ADDRESS = re.compile(r'http://\S+/lab\?token=\w+')
POLL_INTERVAL = 0.2  # [s]
PAGE_CONFIG = {'disabledExtensions': {'@jupyterlab/apputils-extension:announcements': True}}  # it asks the user


def options_of(arguments: Sequence[str]) -> Tuple[argparse.Namespace, List[str]]:
    """Return (options, further arguments for JupyterLab)."""
    parser = argparse.ArgumentParser(prog='./run view --terminal', description=__doc__.partition('\n')[0],
                                     epilog='All other options are those of jupyter lab, such as --ip=0.0.0.0.')
    parser.add_argument('jupyter', help=argparse.SUPPRESS)
    parser.add_argument('--port', type=int, default=8888, help='of JupyterLab (default: %(default)s)')
    parser.add_argument('--folder', type=lambda text: os.path.realpath(os.path.expanduser(text)),
                        help='whose files the editor shows, and no others (default: your home folder, opened in the '
                        'current folder)')
    return parser.parse_known_args(arguments)


def shown_folders(folder: Optional[str], here: str) -> Tuple[str, str]:
    """Return (root, opened): the folder that the editor shows, and the one in it, relative, that is opened at first.

    ``folder``: what the user asks for, or None: home, so that the paths of the course, which begin with ~, lie in it.
    """
    root = folder or os.path.realpath(os.path.expanduser('~'))
    if not (folder or os.path.isdir(root)):
        root = here
    opened = os.path.relpath(here, root)
    hidden = any(part.startswith('.') for part in opened.split('/'))  # above the root, the root, or not shown
    return root, '' if hidden else opened


def configuration(port: Optional[int], jupyter: str, opened: str = '') -> Dict[str, Any]:
    """Return the settings of JupyterLab: its launcher opens the page, which listens at ``port``, as a tab.

    Its terminals are those of ./run shell, by a file in the workspace that holds ``jupyter``. By itself it would start
    login shells, whose /etc/profile takes the workspace out of PATH.
    """
    rc_file = pathlib.Path(jupyter).absolute().parents[2] / 'shell.bash'
    shell = ['bash', '--rcfile', str(rc_file), '-i'] if rc_file.exists() else ['bash']
    page: Dict[str, Any] = {'command': [], 'port': port, 'timeout': 20, 'new_browser_tab': False,
            'launcher_entry': {'title': TITLE}}
    return {'ServerProxy': {'servers': {'turtle_robotont': page}}, 'HomeContents': {'preferred_dir': opened},
            'ServerApp': {'open_browser': False, 'allow_root': os.getuid() == 0,
                          'contents_manager_class': 'course_page.home_contents.HomeContents',
                          'terminado_settings': {'shell_command': shell}}}


def write_configuration(folder: pathlib.Path, settings: Dict[str, Any]) -> None:
    (folder / 'jupyter_server_config.json').write_text(json.dumps(settings), encoding='utf-8')
    (folder / 'labconfig').mkdir()
    (folder / 'labconfig' / 'page_config.json').write_text(json.dumps(PAGE_CONFIG), encoding='utf-8')


def main() -> None:
    options, further = options_of(rospy.myargv()[1:])
    make_interruptible()
    here = os.path.realpath(os.getcwd())
    root, opened = shown_folders(options.folder, here)
    if not os.path.isdir(root):
        sys.exit(f'--folder {root} is not a folder.')
    if not options.folder and os.path.commonpath([root, here]) != root:
        print(f'The editor shows {root} and what is in it. This folder is not: to edit its files, end this by Ctrl-C '
              f'and add --folder {shlex.quote(here)}', flush=True)
    running = running_page()
    port = urllib.parse.urlsplit(running.address).port if running else free_port()
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix='turtle_robotont_terminal_'))
        write_configuration(pathlib.Path(folder), configuration(port, options.jupyter, opened))
        if not running:
            stack.enter_context(BackgroundProcess([*PAGE, f'--port={port}', f'--programs={root}'],
                                                  os.path.join(folder, 'page.txt')))
        lab = stack.enter_context(BackgroundProcess(
            [options.jupyter, 'lab', f'--port={options.port}', f'--ServerApp.root_dir={root}', *further],
            os.path.join(folder, 'lab.txt'), env={**os.environ, 'JUPYTER_CONFIG_DIR': folder}))
        with contextlib.suppress(KeyboardInterrupt):
            print_address(lab)
            lab.process.wait()
        if lab.process.returncode:
            sys.exit(f'JupyterLab ended:\n{lab.output()}')


def print_address(lab: BackgroundProcess) -> None:
    """Print the address when JupyterLab has logged it. Its log would scroll the address away, so it is not shown."""
    while lab.runs():
        match = ADDRESS.search(lab.output())
        if match:
            print(f'Open {match.group()} in a browser, and there the tab "{TITLE}". Ctrl-C ends it.', flush=True)
            return
        time.sleep(POLL_INTERVAL)
