"""Many clients at once that spawn, kill, reset, clear, draw, teleport, pause, resume and step."""

import contextlib
import random
import threading
import time

from robotont_gazebo.srv import SetPose
from sim_ros.srv import Step
from std_srvs.srv import Trigger
from turtlesim.srv import SetPen

import tcpros
from figures import OURS, Figure, Target, median
from trial import PEN, Attack, Trial, losses
from under_test import SERVICES, TROUBLE, running, serialized

CLIENTS = 8
STORM_DEADLINE = 30.0  # [s] for one answer in the middle of a storm
NAMES = tuple(f'storm{number}' for number in range(5))
MIDDLE = 5.544444561004639  # [m]


def turtlesim(subject, scale, rng):
    """All services of a turtle simulator."""
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        node.call('/reset')
        trial = Trial(node)
        makers = [_turtle_request]
        if subject.side == OURS:
            makers.append(_time_request('/turtlesim'))
        _storm(trial, scale, rng, makers)
        with contextlib.suppress(*TROUBLE):  # the trial tells what an end means
            _let_go(node, '/turtlesim')
            node.call('/reset', timeout=STORM_DEADLINE)
            node.call('/turtle1/set_pen', *PEN, timeout=STORM_DEADLINE)
        return trial.samples('turtles')


def robotont(subject, scale, rng):
    """All services of the robot's simulator, except to move a panel."""
    with running(subject, 'robotont') as nodes:
        node = nodes['robotont']
        start = SetPose._request_class(-2.0, 0.0, 0.0)
        _call(node, '/robotont_gazebo/set_pose', SetPose, start)
        trial = Trial(node)
        _storm(trial, scale, rng, [_robot_request, _time_request('/robotont_gazebo')])
        with contextlib.suppress(*TROUBLE):
            _let_go(node, '/robotont_gazebo')
            _call(node, '/robotont_gazebo/set_pose', SetPose, start)
        return trial.samples('robots')


def _turtle_request(rng):
    """Return (service, class, request) of a call that may fail because of other clients."""
    name = rng.choice(NAMES)
    choice = rng.choice((('/spawn', (5.0, 5.0, 0.0, name)), ('/spawn', (5.0, 5.0, 0.0, '')), ('/kill', (name,)),
                         ('/reset', ()), ('/clear', ()), ('/turtle1/set_pen', (rng.randrange(256), 0, 0, 3, 0)),
                         ('/turtle1/teleport_absolute', (rng.uniform(1.0, 10.0), 5.0, 0.0)),
                         ('/turtle1/teleport_relative', (1.0, 1.0))))
    kind = SERVICES[choice[0].rpartition('/')[2]]
    return choice[0], kind, kind._request_class(*choice[1])


def _time_request(node):
    def make(rng):
        word = rng.choice(('pause', 'resume', 'step'))
        if word == 'step':
            return f'{node}/step', Step, Step._request_class(rng.randint(1, 5))
        return f'{node}/{word}', Trigger, Trigger._request_class()
    return make


def _robot_request(rng):
    return '/robotont_gazebo/set_pose', SetPose, SetPose._request_class(rng.uniform(-2.5, -1.5), 0.0, 0.0)


def _storm(trial, scale, rng, makers):
    """Let CLIENTS threads call services for a time, each with its own seeded numbers."""
    end = time.monotonic() + scale.seconds(60.0, 5.0)
    lock = threading.Lock()

    def client(seed):
        own = random.Random(seed)
        while time.monotonic() < end and trial.node.runs() and trial.hung < CLIENTS:
            name, kind, request = own.choice(makers)(own)
            never = _asked(trial.node, name, kind, request)
            with lock:
                trial.inputs += 1
                trial.hung += never
    threads = [threading.Thread(target=client, args=(rng.randrange(2 ** 31),), daemon=True) for _ in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def _asked(node, name, kind, request):
    """Make a call; return whether it was never answered."""
    try:
        _call(node, name, kind, request)
    except tcpros.NeverAnswered:
        return True
    except TROUBLE:
        pass  # refused, or the turtle is gone meanwhile
    return False


def _call(node, name, kind, request):
    caller = node.caller(name, kind, STORM_DEADLINE)
    try:
        return caller.call(serialized(request))
    finally:
        caller.close()


def _let_go(node, name):
    """End a pause that a storm may have left."""
    if node.subject.side == OURS and node.runs():
        _call(node, f'{name}/resume', Trigger, Trigger._request_class())


def pairs(subject, scale, _rng):
    """Calls of one client back to back, on persistent connections."""
    count = scale.count(100, 10)
    with running(subject, 'turtlesim') as nodes:
        node = nodes['turtlesim']
        spawn, kill = node.caller('/spawn'), node.caller('/kill')
        made = serialized(SERVICES['spawn']._request_class(5.0, 5.0, 0.0, 'pair'))
        gone = serialized(SERVICES['kill']._request_class('pair'))
        found = {'pair_time': _times(lambda: (spawn.call(made), kill.call(gone)), count)}
        for name, request in (('/reset', b''), ('/clear', b''),
                              ('/turtle1/set_pen', serialized(SetPen._request_class(*PEN)))):
            key = name.rpartition('/')[2]
            found[f'{key}_time'] = _times(_calling(node.caller(name), request), count)
        return found


def _calling(caller, request):
    return lambda: caller.call(request)


def _times(call, count):
    """Return the times [ms] of this many calls."""
    found = []
    for _ in range(count):
        begun = time.monotonic()
        call()
        found.append(1e3 * (time.monotonic() - begun))
    return found


ATTACKS = {
    'turtles': Attack(turtlesim, 'everything at once, turtle simulator'),
    'robots': Attack(robotont, "everything at once, the robot's simulator", peer=False),
    'pairs': Attack(pairs, 'times of calls back to back'),
}
SAME = Target('ratio', 1.05)
FIGURES = (
    *losses('turtles', 'storm on turtles'),
    *losses('robots', 'storm on a robot'),
    Figure('spawn and kill, back to back', 'pair_time', 'ms', median, SAME),
    Figure('reset, back to back', 'reset_time', 'ms', median, SAME),
    Figure('clear, back to back', 'clear_time', 'ms', median, SAME),
    Figure('set_pen, back to back', 'set_pen_time', 'ms', median, SAME),
)
