"""Find the topic or service that a misspelled name means. Without ROS."""
import difflib
import re
from typing import Iterable, Optional

SIMILAR = 0.75  # ratio of difflib.SequenceMatcher for two names: /turtle1/cmd_vel and /turtle1/cmdvel have 0.97
OF_EVERY_NODE = re.compile(r'/rosout(_agg)?|/clock|/tf(_static)?|/statistics|/diagnostics|'
                           r'.*/(get_loggers|set_logger_level|parameter_updates|parameter_descriptions)')


def meant(name: str, known: Iterable[str]) -> Optional[str]:
    """Return the known name that resembles a wrong one: with the same last part, else similar as a whole; or None."""
    last, names = _last(name), sorted(known)
    same = [candidate for candidate in names if _last(candidate) == last]
    similar = difflib.get_close_matches(name, same or names, 1, 0.0 if same else SIMILAR)
    return similar[0] if similar else None


def _last(name: str) -> str:
    return name.rsplit('/', 1)[-1].lower()
