"""What servers and clients of actions share: a server whose goals always end, a client that notices a lost server.

Threading contract: a goal is executed in the thread of its SimpleActionServer; ``run_goal`` is called in any thread.
"""
import math
import threading
import time

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatusArray

from rospy_support import rospy_internals

REMINDER = 5.0  # [s] while there is no server
GONE = 3.0  # [s] without a connection to the server; a restart of the master needs less
POLL = 0.1  # [s] of wall time between two looks at the connection
GOING_DOWN = 'the server is being shut down'


class Refused(ValueError):
    """A goal cannot be reached; the text says why, and what is allowed; ``result``: what there is of it."""

    def __init__(self, text, result=None):
        super().__init__(text)
        self.result = result


class Preempted(Exception):
    """The client has cancelled the goal, or another goal has come."""


def serve(action, execute, name=None):
    """Serve an action under a name, by default that of the node, and return its SimpleActionServer.

    ``execute(goal, server)`` returns the result of the goal. It raises Refused to abort the goal, and Preempted when
    ``check`` has said so.
    """
    name = rospy.resolve_name(name) if name else rospy.get_name()

    def run(goal):
        try:
            result = execute(goal, server)
            rospy.loginfo('%s: Succeeded', name)
            server.set_succeeded(result)
        except Preempted:
            rospy.loginfo('%s: Preempted', name)
            server.set_preempted()
        except Refused as refusal:
            rospy.logwarn('%s: Aborted: %s', name, refusal)
            server.set_aborted(refusal.result, str(refusal))
        except rospy.ROSInterruptException:
            pass  # the hook has told the client

    def end():
        if server.is_active():
            server.set_aborted(text=GOING_DOWN)
    server = actionlib.SimpleActionServer(name, action, execute_cb=run, auto_start=False)
    rospy.on_shutdown(end)
    server.start()
    return server


def check(server):
    """Raise Preempted if the goal that a SimpleActionServer executes has been cancelled, or replaced by a new one."""
    if server.is_preempt_requested():
        raise Preempted
    _check_shutdown()


def _check_shutdown():
    if rospy_internals.shutting_down():
        raise rospy.ROSInterruptException(GOING_DOWN)


def run_goal(name, action, goal, patience=math.inf, feedback=None):
    """Send a goal to the server of an action, wait for its end, and return the goal's ClientGoalHandle.

    It waits for the server as long as it takes, and for the result up to ``patience`` [s of wall time]; ``feedback``:
    a function that takes each one. Raises SystemExit if the server ends before the goal does, or if the patience is
    over; the goal is cancelled then, and also when this node is shut down.
    """
    client, done = actionlib.ActionClient(name, action), threading.Event()  # the simple one can miss an early end
    name = rospy.resolve_name(name)
    status = rospy.Subscriber(f'{name}/status', GoalStatusArray)
    _wait_for_server(client, name)
    sent = client.send_goal(goal, lambda one: one.get_comm_state() == actionlib.CommState.DONE and done.set(),
                            feedback and (lambda _, one: feedback(one)))
    rospy.on_shutdown(lambda: done.is_set() or sent.cancel())
    begin = heard = time.monotonic()
    while not done.wait(POLL):
        _check_shutdown()
        now = time.monotonic()
        heard = now if status.get_num_connections() else heard
        if now - heard > GONE:
            raise SystemExit(f'The server of the action {name} has gone: there will be no result.')
        if now - begin > patience:
            sent.cancel()
            raise SystemExit('Action did not finish before the time out.')
    return sent


def _wait_for_server(client, name):
    rospy.loginfo('Waiting for action server to start.')
    while not client.wait_for_server(rospy.Duration(REMINDER)):
        _check_shutdown()
        rospy.logwarn('There is no server of the action %s yet. Start one in another terminal', name)
    rospy.loginfo('Action server started, sending goal.')


def report(sent):
    """Log in which state the goal of a ClientGoalHandle has ended, and why; raise SystemExit(1) if not succeeded."""
    state = sent.get_goal_status()
    text = sent.get_goal_status_text()
    rospy.loginfo('Action finished: %s%s', actionlib.GoalStatus.to_string(state), f' ({text})' if text else '')
    if state != actionlib.GoalStatus.SUCCEEDED:
        raise SystemExit(1)
