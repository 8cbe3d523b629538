"""The Dockerfile, compose.yaml, .devcontainer and workflow: what must agree, and what may be reached from elsewhere.

No container engine is needed: hadolint checks the Dockerfile, the rest is read.
"""
import json
import pathlib
import re
import shlex
import shutil
import subprocess
from xml.etree import ElementTree

import pytest
import yaml

from course_page.panels import PORT
from unit_support import REPOSITORY

DOCKERFILE = (REPOSITORY / 'Dockerfile').read_text()
COMPOSE = yaml.safe_load((REPOSITORY / 'compose.yaml').read_text())
COURSE = COMPOSE['services']['course']
DEVCONTAINER = json.loads((REPOSITORY / '.devcontainer' / 'devcontainer.json').read_text())
WORKFLOW = yaml.safe_load((REPOSITORY / '.github' / 'workflows' / 'ci.yml').read_text())
SYSTEMS = WORKFLOW['jobs']['system']['strategy']['matrix']['include']


def instructions(name):
    """Return the arguments of all instructions of the Dockerfile with this name."""
    return re.findall(rf'^{name} (.*)$', DOCKERFILE, re.MULTILINE)


def may_fail(system):
    return system.get('may_fail', False)


def variable(name):
    value, = (setting.partition('=')[2] for setting in instructions('ENV') if setting.startswith(f'{name}='))
    return pathlib.PurePosixPath(value)


@pytest.mark.skipif(not shutil.which('hadolint'), reason='hadolint is not installed: ./run test installs it')
def test_hadolint_has_no_warning():
    result = subprocess.run(['hadolint', '--failure-threshold', 'warning', REPOSITORY / 'Dockerfile'],
                            capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


def test_the_image_is_of_a_system_that_the_workflow_tries():
    image, = instructions('FROM')
    assert image in {row['image'] for row in SYSTEMS if not may_fail(row)}


def test_programs_do_not_run_as_root():
    user = instructions('USER')[-1]
    assert f' {user}' in ''.join(line for line in DOCKERFILE.splitlines() if 'useradd' in line)
    assert DEVCONTAINER['remoteUser'] == user and 'user' not in COURSE
    assert DOCKERFILE.rindex('\nRUN ') < DOCKERFILE.rindex('\nUSER ')  # installed files belong to root


def test_the_port_of_the_page_is_one_number():
    """Published to this machine alone, and by the number that the page prints in its address."""
    assert COURSE['ports'] == [f'127.0.0.1:{PORT}:{PORT}']
    assert instructions('EXPOSE') == [str(PORT)]
    assert DEVCONTAINER['forwardPorts'] == [PORT] and list(DEVCONTAINER['portsAttributes']) == [str(PORT)]
    launch = ElementTree.parse(REPOSITORY / 'launch' / 'browser.launch').getroot()
    assert launch.find('arg[@name="port"]').get('default') == str(PORT)


@pytest.mark.parametrize('page', [REPOSITORY / 'README.md', REPOSITORY / '.github' / 'workflows' / 'ci.yml',
                                  *sorted(REPOSITORY.glob('docs/*.md'))], ids=lambda page: page.name)
def test_texts_name_the_port_of_the_page(page):
    found = re.findall(r'http://(?:localhost|127\.0\.0\.1):(\d+)/', page.read_text())
    assert set(found) <= {str(PORT)}


def test_what_the_container_starts_is_a_page_that_its_port_leads_to():
    command = shlex.split(COURSE['command'])
    assert command == shlex.split(DEVCONTAINER['postAttachCommand']) == json.loads(instructions('CMD')[-1])
    assert command == ['./run', 'view', '--turtlesim']
    assert str(variable('TURTLE_ROBOTONT_ADDRESS')) == '0.0.0.0'


def test_the_whole_home_is_a_volume_that_is_found_again():
    """~/ros_ws, bags and maps as well as the workspace; a volume without a name would go with its container."""
    home = f'/home/{instructions("USER")[-1]}'
    assert f'home:{home}' in COURSE['volumes'] and 'home' in COMPOSE['volumes']
    assert COMPOSE['name'] == 'turtle_robotont'  # else the name of the volume begins with that of the clone's folder
    mount, = DEVCONTAINER['mounts']
    source, target, kind = mount.split(',')
    assert (target, kind) == (f'target={home}', 'type=volume')
    assert source.startswith('source=turtle_robotont-home-') and '${devcontainerId}' in source  # stays in a rebuild
    assert '--uid 1000 ' in DOCKERFILE  # of the files in a volume that an earlier image has filled


def test_the_workspace_that_the_image_built_lies_in_the_volume():
    workspace = variable('TURTLE_ROBOTONT_WS')
    assert workspace.parent.parent == pathlib.PurePosixPath(f'/home/{instructions("USER")[-1]}')
    there = DEVCONTAINER['containerEnv']['TURTLE_ROBOTONT_WS']
    assert there == f'{workspace.parent}/${{containerWorkspaceFolderBasename}}'




def test_the_folder_of_the_results_is_in_the_clone_and_belongs_to_who_cloned():
    """Docker makes a missing folder as root, whose files neither the container nor the host can write."""
    assert (REPOSITORY / 'output' / '.gitignore').read_text().split() == ['*', '!.gitignore']
    assert 'output' not in (REPOSITORY / '.gitignore').read_text()  # nothing below an ignored folder can be kept
    assert re.search(r'chown -R student: .*\boutput\b', DOCKERFILE)  # of an image that is started without compose


def test_the_checkout_is_where_the_image_has_it():
    folder = pathlib.PurePosixPath(instructions('WORKDIR')[-1])
    assert DEVCONTAINER['workspaceFolder'] == str(folder) and f'target={folder},' in DEVCONTAINER['workspaceMount']
    assert folder.name == variable('TURTLE_ROBOTONT_WS').name  # ${containerWorkspaceFolderBasename} names the built one
    assert folder.parent == pathlib.PurePosixPath('/workspaces')  # Codespaces puts its checkout there
    assert f'./output:{folder}/output' in COURSE['volumes']


@pytest.mark.parametrize('page', ['tools/workspace.bash', 'docs/installation.md'])
def test_commands_name_the_service(page):
    commands = re.findall(r'docker compose (?:run|exec)(?: --?\S+)* (\w+) \./run', (REPOSITORY / page).read_text())
    assert commands and set(commands) <= set(COMPOSE['services'])


def test_the_image_gets_no_leftovers_of_the_checkout():
    ignored = (REPOSITORY / '.dockerignore').read_text().split()
    assert {'.git', 'output', '**/__pycache__'} <= set(ignored)


def test_only_ubuntu_may_fail():
    assert {row['image'] for row in SYSTEMS if not may_fail(row)} == {'debian:12', 'debian:13'}
    assert {row['image'] for row in SYSTEMS if may_fail(row)} == {'ubuntu:24.04', 'ros:noetic-robot-focal'}


def test_the_workflow_may_only_read():
    assert WORKFLOW['permissions'] == {'contents': 'read'}
    assert all('permissions' not in job for job in WORKFLOW['jobs'].values())
