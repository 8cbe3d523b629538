"""The text and the cure of each problem, for the nodes, ``./run grade`` and ``./run doctor``.

docs/troubleshooting.md has a row for each.
"""
import os
import shlex
from typing import Any, Iterable, Mapping, NamedTuple, Optional, Sequence, Tuple

SHEBANG = '#!/usr/bin/env python3'
MAX_VALUE_LENGTH = 80  # characters of a parameter: a robot_description has thousands
DOES = {'publishes': 'publishes {0}, which nobody reads', 'subscribes': 'subscribes to {0}, which nobody publishes',
        'serves': 'offers {0}, which nobody calls', 'uses': 'uses {0}, which does not exist'}


class Finding(NamedTuple):
    """A problem.

    name   a stable identifier for scripts
    text   the problem, with the value
    cure   what to do
    fails  True if something will fail, False for a note
    """

    name: str
    text: str
    cure: str
    fails: bool = True

    def __str__(self) -> str:
        return f'{self.text}{"" if self.text.endswith("?") else ";"} {self.cure}'


# ---------------------------------------------------------------------------------------------------- system

def packages_unavailable(packages: Iterable[str]) -> Finding:
    """``apt`` does not offer Debian packages that are missing."""
    return Finding('packages_unavailable', f'apt does not offer: {", ".join(packages)}',
                   "add Debian's main to /etc/apt/sources.list, then type apt-get update")


def packages_forbidden(packages: Iterable[str]) -> Finding:
    return Finding('packages_forbidden', 'Debian packages are missing, and there is no sudo to install them',
                   f'ask an administrator to type apt-get install -y --no-install-recommends {" ".join(packages)}')


def no_answer(command: Sequence[str], seconds: float, fails: bool) -> Finding:
    """A command of a check gave no answer within ``seconds``."""
    return Finding('no_answer', f'{os.path.basename(command[0])} gave no answer within {seconds:.0f} s, so nothing is '
                   'known about what it was asked for', 'type ./run doctor again when the machine is less busy', fails)


def disk_full(folder: str, free: float, needed: float) -> Finding:
    """``free`` and ``needed``: space [MB]."""
    return Finding('disk_full', f'the disk of {folder} has {free:.0f} MB left of the {needed:.0f} MB that are needed',
                   f'make room; df -h {folder} shows the disk')


def addresses_limited(limit: float, needed: float) -> Finding:
    """``limit`` and ``needed``: address space [MB] of a process."""
    return Finding('addresses_limited', f'a program gets {limit:.0f} MB of addresses here (ulimit -v); OpenCV and the '
                   f'threads of a node need {needed:.0f} MB',
                   'type ulimit -v unlimited, or raise "as" in /etc/security/limits.conf')


def loopback_down(said: str) -> Finding:
    return Finding('loopback_down', f'nothing on this machine can reach 127.0.0.1 ({said}), so no node finds '
                   'its master', 'type sudo ip link set lo up')


def no_network(packages: int) -> Finding:
    return Finding('no_network', f'{packages} Debian packages are missing, and this machine has no network to '
                   'load them from',
                   'check the cable or the wifi (ip route shows no default), or set http_proxy')


def workspace_impossible(workspace: str, folder: str, user: str) -> Finding:
    """There is no workspace yet, and ``user`` cannot make one."""
    return Finding('workspace_impossible',
                   f'./run cannot make its workspace {workspace}: {user} cannot write to {folder}',
                   'choose another folder: type TURTLE_ROBOTONT_WS=/tmp/turtle_ws ./run build')


def folder_not_writable(folder: str, owner: str, user: str) -> Finding:
    return Finding('folder_not_writable', f'{user} cannot write to {folder}, which belongs to {owner}',
                   f'type sudo chown -R {user} {folder}')


def python_shadowed(python: str, why: str, cure: str, fails: bool) -> Finding:
    return Finding('python_shadowed', f'python3 is {python}{why}, where ROS is not installed', cure, fails)


def foreign_variable(name: str, value: str, inside: bool) -> Finding:
    """A variable makes Python, ROS or the linker look elsewhere; ``inside``: in ./run shell, which has unset it."""
    cure = (f'type unset {name} and open ./run shell again' if inside else
            f'./run removes it, a catkin workspace of your own does not: type unset {name}')
    return Finding('foreign_variable', f'{name} is {value}, which does not belong to ROS 1 here', cure, fails=inside)


def opencv_unusable(python: str, said: str) -> Finding:
    return Finding('opencv_unusable', f'{python}: {said}', 'type ./run clean, then ./run build')


def time_set_back(file: str, seconds: float) -> Finding:
    return Finding('time_set_back', f'{file} was written {_span(seconds)} from now: the clock was set back',
                   'set the clock (timedatectl set-ntp true), or type touch on that file', fails=False)


def clock_jumps(seconds: float) -> Finding:
    """The wall clock runs faster or slower than elapsed time, by ``seconds`` per second."""
    return Finding('clock_jumps', f'the clock gains {seconds:+.2f} s per second of elapsed time',
                   'nodes that wait for times will wait too long or not at all; check chrony, ntp or the host of this '
                   'virtual machine')


def no_isolation(said: str) -> Finding:
    return Finding('no_isolation', f'a program cannot be isolated from this machine ({said})',
                   'grade only programs that you trust, or type sudo apt-get install bubblewrap and '
                   'sudo sysctl kernel.unprivileged_userns_clone=1', fails=False)


# ---------------------------------------------------------------------------------------------------- terminal

def outside_shell(package: str, command: str) -> Finding:
    """The terminal does not know the packages, such as ``package``; ``command`` opens one that does."""
    return Finding('outside_shell', 'this terminal is not a ./run shell: here, rosrun says "command not found" or '
                   f'"[rospack] Error: package {package!r} not found"', f'type {command}', fails=False)


def shell_overridden(file: str) -> Finding:
    """A ./run shell has lost the packages; sourcing ``file`` brings them back."""
    return Finding('shell_overridden', 'this ./run shell no longer finds the packages: the setup.bash of another '
                   'workspace, built outside of ./run shell, has replaced them',
                   f'type source {file}; then delete build and devel of that workspace, and build it here with '
                   'catkin_make')


def workspace_not_sourced(workspace: str) -> Finding:
    return Finding('workspace_not_sourced', f'this terminal does not know the packages of {workspace}',
                   f'type source {workspace}/devel/setup.bash', fails=False)


def no_roscore(uri: str, other: Optional[Tuple[str, str]] = None) -> Finding:
    """No program uses the port of the terminal's master; ``other``: a master of this user, and its URI."""
    if other:
        return Finding('no_roscore', f'no roscore runs at {uri}, which is the ROS_MASTER_URI of this terminal; '
                       f'{other[0]} is one at {other[1]}', f'type export ROS_MASTER_URI={other[1]} to use that one, or '
                       'roscore in another terminal that has the same ROS_MASTER_URI as this one', fails=False)
    return Finding('no_roscore', f'no roscore runs at {uri}, which is the ROS_MASTER_URI of this terminal',
                   'type roscore in another ./run shell', fails=False)


# ---------------------------------------------------------------------------------------------------- programs

def not_executable(path: str) -> Finding:
    return Finding('not_executable', f'{path} is not executable, so rosrun cannot start it',
                   f'type chmod +x {shlex.quote(path)}', fails=False)


def windows_line_ends(path: str) -> Finding:
    return Finding('windows_line_ends', f'the lines of {path} end with CR LF (Windows), so Linux does not find the '
                   'interpreter', f"type sed -i 's/\\r$//' {shlex.quote(path)}")


def byte_order_mark(path: str) -> Finding:
    return Finding('byte_order_mark', f'{path} starts with a byte order mark (Windows), which hides its first line '
                   'from Linux', f"type sed -i '1s/^\\xEF\\xBB\\xBF//' {shlex.quote(path)}")


def no_shebang(path: str) -> Finding:
    return Finding('no_shebang', f'the first line of {path} is not {SHEBANG}, so the program is run by bash instead of '
                   'Python', f"type sed -i '1i {SHEBANG}' {shlex.quote(path)}")


def wrong_shebang(path: str, line: str, why: str) -> Finding:
    """The first ``line`` of a program names another interpreter than Python 3."""
    return Finding('wrong_shebang', f'the first line of {path} is {line}, and {why}: it should be {SHEBANG}',
                   f"type sed -i '1s|.*|{SHEBANG}|' {shlex.quote(path)}")


def wrong_extension(path: str, right: str) -> Finding:
    return Finding('wrong_extension', f'{path} is a Python program whose name does not end with .py',
                   f'type mv {shlex.quote(path)} {shlex.quote(right)}', fails=False)


def outside_package(path: str) -> Finding:
    return Finding('outside_package', f'{path} is not in a package, so rosrun cannot find it',
                   'move it into the folder scripts of a package; catkin_create_pkg NAME rospy makes one', fails=False)


def does_not_end(process: str, seconds: float, pid: int) -> Finding:
    """A node still runs although it was told to end ``seconds`` ago."""
    return Finding('does_not_end', f'{process} was told to end {_span(seconds)} ago and still runs',
                   f'press Ctrl-\\ in its terminal, or type kill -9 {pid}; a loop that Ctrl-C ends starts with '
                   'while not rospy.is_shutdown():', fails=False)


# ---------------------------------------------------------------------------------------------------- network

def name_without_address(source: str, name: str, cure: str) -> Finding:
    """The address that this machine announces, which comes from ``source``, is a name that cannot be resolved."""
    return Finding('name_without_address', f'{source} is {name!r}, a name that has no address', cure)


def address_not_here(source: str, address: str, cure: str) -> Finding:
    return Finding('address_not_here', f'{source} is {address}, which is not an address of this machine: nodes on '
                   'other machines cannot reach its nodes and receive nothing from them', cure)


def address_only_here(source: str, address: str, master: str, cure: str) -> Finding:
    return Finding('address_only_here', f'The master is on another machine ({master}), but {source} is {address}, '
                   'which other machines cannot use: nodes there receive nothing from this one', cure)


def bad_master_uri(uri: str) -> Finding:
    return Finding('bad_master_uri', f'ROS_MASTER_URI is {uri!r}, which is not http://HOST:PORT',
                   'type unset ROS_MASTER_URI and open ./run shell again')


def master_unreachable(uri: str, said: str) -> Finding:
    return Finding('master_unreachable', f'no ROS master answers at {uri} on another machine ({said})',
                   'start roscore there, with its ROS_IP set; if you want one here, type unset ROS_MASTER_URI')


def port_taken(port: int, holder: str) -> Finding:
    return Finding('port_taken', f"the master's port {port} is taken by {holder}, which is not a ROS master",
                   f'end it, or choose another port: export ROS_MASTER_URI=http://localhost:{port + 1}')


def master_hangs(uri: str, holder: str) -> Finding:
    return Finding('master_hangs', f'{holder} has the port of {uri} and does not answer: is it suspended?',
                   'type fg in the terminal of roscore, or end it')


def foreign_master(uri: str, user: str, pid: int) -> Finding:
    return Finding('foreign_master', f'the ROS master at {uri} belongs to the user {user} (process {pid}): nodes '
                   'with the same name end each other',
                   'type unset ROS_MASTER_URI, then ./run shell, which gives you a master of your own')


def exposed(holder: str, address: str) -> Finding:
    return Finding('exposed', f'{holder} listens on {address}: every machine in the network can reach it',
                   'start it with ROS_HOSTNAME=localhost (./run shell sets it); docs/two_machines.md says more',
                   fails=False)


# ---------------------------------------------------------------------------------------------------- master

def stale_parameters(node: str, values: Mapping[str, Any]) -> Finding:
    """Private parameters {name without the node: value} that were on the master before ``node`` started."""
    said = ', '.join(f'{name}={_typed(value)}' for name, value in sorted(values.items()))
    return Finding('stale_parameters', f'{node} has parameters from an earlier run: {said}',
                   f'rosparam delete {node} forgets them', fails=False)


def stale_registration(node: str, uri: str) -> Finding:
    return Finding('stale_registration', f'{node} is registered at {uri}, but does not answer there',
                   'rosnode cleanup forgets nodes that have ended', fails=False)


def no_clock() -> Finding:
    return Finding('no_clock', '/use_sim_time is true, but no node publishes /clock: nodes wait for it forever',
                   'start the simulator with _clock:=true, or type rosparam delete /use_sim_time and start the nodes '
                   'again')


def two_clocks(nodes: Iterable[str]) -> Finding:
    return Finding('two_clocks', f'{" and ".join(nodes)} publish /clock, so time will jump',
                   'start one of the simulators with _clock:=false')


def misnamed(who: str, role: str, name: str, meant: str) -> Finding:
    """A node uses a name that no other node uses; ``role`` is one of DOES, ``meant`` a similar name that exists."""
    return Finding('misnamed', f'{who} {DOES[role].format(name)}: did you mean {meant}?',
                   f'Correct the name in the program, or add {name}:={meant} to its command', fails=False)


def nobody_publishes(who: str, name: str) -> Finding:
    return Finding('nobody_publishes', f'{who} {DOES["subscribes"].format(name)}',
                   'start the node that publishes it, or correct the name; rostopic list shows all topics', fails=False)


def two_types(topic: str, users: Sequence[Tuple[str, str]]) -> Finding:
    return Finding('two_types', f'both ends of {topic} need the same type: '
                   + ', '.join(f'{who} has {kind}' for who, kind in users),
                   'import the right one: from turtlesim.msg import Pose for the pose of a turtle, from '
                   'geometry_msgs.msg import Twist for a velocity; a program that receives it needs rospy.Subscriber')


# ---------------------------------------------------------------------------------------------------- packages

def package_to_install(name: str, file: str, debian: Sequence[str], fails: bool) -> Finding:
    """A package or module that ``file`` names first is missing, and Debian has it."""
    return Finding('package_to_install', f'{name} is missing, which {file} needs',
                   f'type sudo apt-get install --no-install-recommends {" ".join(debian)}', fails)


def package_not_to_be_had(name: str, file: str, instead: str, module: bool, fails: bool) -> Finding:
    """A package or ``module`` that ``file`` names first is missing, and neither Debian nor this repository has it."""
    cure = instead or ((f'if PyPI has it, type pip install {name} in a ./run shell; else' if module else
                        'put its source into the src folder of your workspace, or') + ' go without it')
    return Finding('package_not_to_be_had', f'{name} is missing, which {file} needs, and Debian does not have it', cure,
                   fails)


def python2_program(path: str, line: int, what: str) -> Finding:
    return Finding('python2_program', f'{path} is written for Python 2: line {line}: {what}',
                   f'type 2to3 -w {shlex.quote(path)} (sudo apt-get install 2to3), then read what it has changed')


# ---------------------------------------------------------------------------------------------------- machine

def no_window(why: str, snapshot: str) -> Finding:
    """The simulator cannot open a window, as requested; ``snapshot``: the service that saves a picture."""
    return Finding('no_window', f'No window: {why}', f'rosservice call {snapshot} saves a picture of the turtle',
                   fails=False)


def dead_display(display: str, said: str = '') -> Finding:
    """There is no X server at DISPLAY; ``said``: the error of an attempt to use it."""
    return Finding('dead_display', f'No window: the display DISPLAY={display} does not answer'
                   + (f' ({said})' if said else ''), 'set DISPLAY to an X server that runs, or see the turtle '
                   'without a window: rosservice call /turtlesim/snapshot saves a picture', fails=False)


def left_over(holder: str, what: str) -> Finding:
    return Finding('left_over', f'{holder} still runs, though what started it has ended: {what}',
                   f'end it: kill {holder.rpartition(" ")[2].rstrip(")")}', fails=False)


def camera_unusable(said: str) -> Finding:
    text, _, cure = said.partition(': ')
    return Finding('camera_unusable', f'the camera {text} cannot be used', cure, fails=False)


def _typed(value: Any) -> str:
    """Return a parameter's value as rosparam takes it, shortened to a line."""
    text = ' '.join((str(value).lower() if isinstance(value, bool) else str(value)).split())
    return text if len(text) <= MAX_VALUE_LENGTH else f'{text[:MAX_VALUE_LENGTH]}...'


def _span(seconds: float) -> str:
    return f'{seconds / 3600.0:.1f} hours' if seconds >= 3600.0 else f'{seconds:.0f} s'
