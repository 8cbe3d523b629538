"""The text and the cure of each problem, once for the node that meets it and for ``./run doctor`` that looks for it."""
from typing import Any, Mapping, NamedTuple


class Finding(NamedTuple):
    """A problem.

    name   a word for programs, the same in every version
    text   what is wrong, with the value
    cure   what to do
    fails  whether something will fail; if not, it only surprises
    """

    name: str
    text: str
    cure: str
    fails: bool = True

    def __str__(self) -> str:
        return f'{self.text}; {self.cure}'


def stale_parameters(node: str, values: Mapping[str, Any]) -> Finding:
    """Private parameters {name without the node: value} that were on the master before ``node`` started."""
    said = ', '.join(f'{name}={_typed(value)}' for name, value in sorted(values.items()))
    return Finding('stale_parameters', f'{node} has parameters from an earlier run: {said}',
                   f'rosparam delete {node} forgets them', fails=False)


def no_clock() -> Finding:
    """Nodes follow a clock that nobody publishes."""
    return Finding('no_clock', '/use_sim_time is true, but no node publishes /clock: nodes wait for it forever',
                   'start the simulator with _clock:=true, or type rosparam delete /use_sim_time and start the nodes '
                   'again')


def no_window(why: str, snapshot: str = '/turtlesim/snapshot') -> Finding:
    """The simulator opens no window; ``snapshot``: the service that saves a picture."""
    return Finding('no_window', f'No window: {why}', f'rosservice call {snapshot} saves a picture of the turtle',
                   fails=False)


def _typed(value: Any) -> str:
    """Return a parameter's value as rosparam takes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)
