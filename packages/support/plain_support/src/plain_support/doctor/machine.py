"""The folders and the environment that the checks examine."""
import os
from typing import Callable, Iterator, List, Mapping, NamedTuple

from plain_support.doctor.findings import Finding


class Machine(NamedTuple):
    """The machine to examine.

    environment  variables of the terminal
    repository   folder of this checkout
    workspace    folder of its workspace, which may not exist
    ros          folder of a ROS 1 other than the system's, or ''
    missing      Debian packages that ./run would install
    """

    environment: Mapping[str, str]
    repository: str
    workspace: str
    ros: str = ''
    missing: List[str] = []

    @property
    def built(self) -> bool:
        return os.path.exists(os.path.join(self.workspace, '.built'))

    @property
    def python(self) -> str:
        return os.path.join(self.workspace, 'venv', 'bin', 'python3')

    @property
    def inside(self) -> bool:
        return self.environment.get('VIRTUAL_ENV') == os.path.join(self.workspace, 'venv')


Check = Callable[[Machine], Iterator[Finding]]
