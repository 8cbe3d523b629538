"""Why a marker is not found in a photo that a page sends: each photo is searched in a process of its own.

Threading contract: everything runs in the loop's thread.
"""
import asyncio
import contextlib
import json
import subprocess
import sys
from typing import Sequence

from browser_servers.core import web

COMMAND = sys.executable, '-m', 'alvar_core.detection.explained_photo'
TIMEOUT = 30.0  # [s] for a photo
MAX_PHOTOS = 4  # that wait or are searched, one after the other


class PhotoRefused(Exception):
    """A photo that was not searched; ``code`` is that of HTTP, the text is for the user."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Photos:
    """Explains one photo at a time; made in the loop's thread."""

    def __init__(self, command: Sequence[str] = COMMAND, timeout: float = TIMEOUT) -> None:
        self._command, self._timeout = command, timeout
        self._turn, self._waiting = asyncio.Lock(), 0

    async def explain(self, photo: bytes) -> bytes:
        """Return the JSON of alvar_core.detection.explained_photo as bytes; raise PhotoRefused."""
        if self._waiting >= MAX_PHOTOS:
            raise PhotoRefused(503, f'{MAX_PHOTOS} photos are being searched already: try again in some seconds')
        self._waiting += 1
        try:
            async with self._turn:
                explanation = await self._run(photo)
        finally:
            self._waiting -= 1
        try:
            error = json.loads(explanation).get('error')
        except ValueError:
            error = 'The search of this photo failed: save it as a JPEG or PNG with another program, and try again'
        if error:
            raise PhotoRefused(422, error)
        return explanation

    async def _run(self, photo: bytes) -> bytes:
        process = await asyncio.create_subprocess_exec(*self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            return (await asyncio.wait_for(process.communicate(photo), self._timeout))[0]
        except asyncio.TimeoutError:
            raise PhotoRefused(422, f'The search took more than {self._timeout:g} s: send a smaller photo') from None
        finally:
            with contextlib.suppress(ProcessLookupError):  # it has ended
                process.kill()


class MarkerPhoto(web.Guarded):
    """POST with a JPEG or PNG: why each candidate in it is a marker or not, as JSON ``lines`` and ``picture``."""

    async def post(self) -> None:
        try:
            explanation = await self.settings['photos'].explain(self.request.body)
        except PhotoRefused as refused:
            self.refuse(refused.code, str(refused))
        else:
            self.answer_json(explanation)
