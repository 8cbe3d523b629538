"""Repairs of rospy: Ctrl-C ends every program, and a program that is started before roscore waits for it.

sitecustomize.py beside this file says how it gets into all programs of a workspace. Programs must not rely on it: they
have to be right with the original rospy, too.

**Ctrl-C.** rospy shuts down inside its signal handler, and so in the main thread. If that thread is just executing
publish() or loginfo(), it holds a lock that the shutdown needs: it waits for itself forever, and only SIGKILL or
SIGQUIT ends the program. Here the shutdown waits until the main thread leaves rospy, a moment later. If it stays there
for PATIENCE, say in the call of a service, another thread shuts down meanwhile. All else is as with the original: the
hooks of rospy.on_shutdown run once, normally in the main thread, which goes on after the shutdown. One thing is new:
GRACE after the first Ctrl-C, another one raises KeyboardInterrupt, as in every Python program. rospy ignores it, so
that a program in input() or in a loop without rospy.is_shutdown() cannot be ended.

**Publishing meanwhile.** A shutdown calls the hooks and closes the topics before rospy.is_shutdown() is true. What
another thread published just then came after the hook's last velocity, or was an error, "publish() to a closed topic".
Here, as a moment later with rospy, nothing happens once the hooks have been called; and what the hooks have published,
such as a velocity of zero, is sent before the topics are closed, which drops what still waits.

**End.** rospy wakes its thread for registrations before it says that the node shuts down, so that the thread sleeps
again, and the shutdown waits for it for half a second. Here it is woken once more.

**Time.** Where /use_sim_time is true and no node publishes /clock, rospy.sleep and rospy.Rate wait forever without a
word. Here a warning says so.

**Start.** Without a master, rospy.init_node ends in a traceback: it reads and sets parameters of the master, but waits
for it only if a topic is registered already. Here it waits in any case, and says so, as roscpp does. Before that it
refuses private parameters of the command line that cannot be sent to a master.
"""
import _thread
import atexit
import contextlib
import importlib.metadata
import os
import re
import signal
import sys
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
import rospy.client
import rospy.core
import rospy.impl.init
import rospy.impl.registration
import rospy.impl.simtime
import rospy.rostime

CHECKED = '1.15.', '1.16.', '1.17.'  # versions of rospy; others stay as they are
PATIENCE = 0.5  # [s] for the main thread to leave rospy; publish and loginfo take less than 1 ms
GRACE = 2.0  # [s] in which further Ctrl-C do nothing, as with rospy: the first one needs some tenths of a second
SHUTDOWN_TIMEOUT = 5.0  # [s] for a shutdown that another thread executes
SENDING_TIMEOUT = 0.2  # [s] for messages that the hooks have published
MASTER_POLL = 0.2  # [s]
CLOCK_PATIENCE = 5.0  # [s] for the source of /clock to start
MASTER_TIMEOUT = 2.0  # [s] for the answer of a master
HOLD_NO_LOCK = {  # functions of rospy that hold no lock while they wait, so that the shutdown may run inside them
    ('rospy.core', 'is_shutdown'), ('rospy.rostime', 'wallsleep'), ('rospy.timer', 'sleep'),
    ('rospy.impl.tcpros_service', 'wait_for_service'), (__name__, '_wait_for_master')}
ALLOWED = ('true, false, whole numbers from -2147483648 to 2147483647, numbers with a decimal point, text, lists of '
           'these, and dictionaries {name: value}. For text that looks like something else, type two pairs of '
           """quotation marks: _x:='"2026-01-31"'""")

_original_signal = rospy.core._ros_signal
_original_start = rospy.impl.init.start_node
_original_publish = rospy.Publisher.publish
_original_time = rospy.impl.simtime.init_simtime
_first_signal = []  # [s, monotonic] when the first one came


def repair():
    """Replace rospy's signal handler, publish() and the function that starts a node; nothing for an unknown rospy."""
    if importlib.metadata.version('rospy').startswith(CHECKED):
        rospy.core._ros_signal = _on_signal
        rospy.impl.init.start_node = _start_node
        rospy.Publisher.publish = _publish
        rospy.impl.simtime.init_simtime = _init_time
        rospy.core.add_preshutdown_hook(_send_rest)  # the first one: it runs directly after the program's hooks
        atexit.register(_await_shutdown)  # runs before rospy's own


def _on_signal(number, frame):
    """Shut down as rospy does, but not while the interrupted main thread is inside rospy."""
    now = time.monotonic()
    _first_signal.append(now)
    if rospy.core._signalChain.get(number) == signal.default_int_handler and now > _first_signal[0] + GRACE:
        signal.default_int_handler(number, frame)
    inside = _frame_to_leave(frame)
    if inside is None or rospy.core._in_shutdown:
        _original_signal(number, frame)
        return

    def leave(left, event, _):
        if left is inside and event == 'return':
            sys.setprofile(None)
            _original_signal(number, left)
            _await_shutdown()
    if sys.getprofile() is None:
        sys.setprofile(leave)
    _thread.start_new_thread(_shut_down_later, (number,))  # threading's own start() takes locks


def _frame_to_leave(frame):
    """Return the outermost frame of rospy in a stack, or None if the main thread holds no lock of rospy."""
    outermost = None
    while frame is not None:
        module = frame.f_globals.get('__name__') or ''
        if module in ('rospy', __name__) or module.startswith('rospy.'):
            if outermost is None and (module, frame.f_code.co_name) in HOLD_NO_LOCK:
                return None
            outermost = frame
        frame = frame.f_back
    return outermost


def _shut_down_later(number):
    """Shut down unless the main thread does so within PATIENCE."""
    end = time.monotonic() + PATIENCE
    while not rospy.core._in_shutdown:
        if time.monotonic() > end:
            _original_signal(number, None)
        time.sleep(0.01)


def _await_shutdown():
    """Wait until another thread has called the hooks of a shutdown, if one does."""
    if rospy.core._shutdown_lock.acquire(timeout=SHUTDOWN_TIMEOUT):
        rospy.core._shutdown_lock.release()


def _publish(publisher, *arguments, **fields):
    """Publish a message; do nothing once a shutdown has called the hooks."""
    if rospy.core._in_shutdown and not rospy.core._client_shutdown_hooks:
        return
    try:
        _original_publish(publisher, *arguments, **fields)
    except rospy.ROSException:
        if not rospy.core._in_shutdown:
            raise


def _send_rest(_):
    """Wait until the threads that write to subscribers have taken and sent what waits."""
    topics = list(rospy.impl.registration.get_topic_manager().pubs.values())
    end = time.monotonic() + SENDING_TIMEOUT
    while time.monotonic() < end and any(getattr(connection, '_queue', None) for topic in topics
                                         for connection in topic.connections):
        time.sleep(0.005)
    time.sleep(0.01)  # for the one that has just been taken


def _start_node(*arguments, **options):
    """Check the parameters on the command line and wait for the master, then start the node."""
    _check_parameters((rospy.client._init_node_args or (None, sys.argv))[1])
    _wait_for_master()
    if rospy.core.is_shutdown():
        sys.exit('Stopped while waiting for the ROS master.')
    node = _original_start(*arguments, **options)
    rospy.core.add_shutdown_hook(lambda _: _wake(node.handler.reg_man))  # these hooks run once is_shutdown() is true
    return node


def _init_time():
    """Initialise the time, and warn if it does not start; rospy_support.nodes does so itself."""
    done = _original_time()
    if done and not rospy.rostime.is_wallclock() and 'rospy_support.nodes' not in sys.modules:
        warning = threading.Timer(CLOCK_PATIENCE, _warn_of_no_clock)
        warning.daemon = True
        warning.start()
    return done


def _warn_of_no_clock():
    """Warn if simulated time has not started because no node publishes /clock."""
    with contextlib.suppress(OSError, rosgraph.MasterException, xmlrpc.client.Error):
        if rospy.rostime.get_rostime().is_zero() and not rospy.core.is_shutdown():
            published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
            if '/clock' not in dict(published):
                rospy.logwarn('/use_sim_time is true, but no node publishes /clock: rospy.sleep and rospy.Rate wait '
                              'forever. Type rosparam delete /use_sim_time and start this program again, or start a '
                              'simulator with _clock:=true.')


def _wake(registering):
    """Let the thread of a RegManager see that the node shuts down."""
    with registering.cond:
        registering.cond.notify_all()


def _check_parameters(argv):
    """End the program if a private parameter on its command line cannot be sent to the master."""
    for argument in filter(rosgraph.names.is_legal_remap, argv):
        try:
            document = xmlrpc.client.dumps((rospy.client.load_command_line_node_params([argument]),))
            xmlrpc.client.loads(document)
        except Exception:  # that of the YAML parser, or of XML-RPC: each part has its own
            document = None
        if document is None or '<dateTime' in document:
            sys.exit(f'The parameter {argument!r} cannot be used. Its value must be one of: {ALLOWED}')


def _wait_for_master():
    """Wait until the master answers or the node is shut down; report the missing master once."""
    uri, told = rosgraph.get_master_uri(), False
    if not re.match(r'https?://\S', uri):
        sys.exit(f'ROS_MASTER_URI is {uri!r}, but must look like http://localhost:11311')
    while not rospy.core.is_shutdown():
        try:
            with xmlrpc.client.ServerProxy(uri, _Transport()) as master:
                master.getPid('/rospy_repair')
        except Exception as error:  # of sockets, HTTP, XML, XML-RPC, or of a host name
            if not told:
                reason = '' if isinstance(error, ConnectionRefusedError) else f' ({error})'
                rospy.logwarn('There is no ROS master at %s%s. Waiting for it: type roscore in another terminal%s.',
                              uri, reason, _other_master())
                told = True
            time.sleep(MASTER_POLL)
        else:
            if told:
                rospy.loginfo('The ROS master is there.')
            return


def _other_master():
    """Return the end of a sentence about a master of this user at another address, '' if there is none."""
    try:
        from plain_support.doctor import processes  # only here: most programs find their master
    except ImportError:  # this folder alone is in the path
        return ''
    found = processes.master_of_user(os.path.dirname(os.environ.get('VIRTUAL_ENV', '')))
    return f'. Or end this program, and type export ROS_MASTER_URI={found[1]}, where one runs' if found else ''


class _Transport(xmlrpc.client.Transport):
    """A connection that waits MASTER_TIMEOUT for an answer."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = MASTER_TIMEOUT
        return connection
