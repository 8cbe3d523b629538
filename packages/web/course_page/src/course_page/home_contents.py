"""The files of JupyterLab, whose paths may also be typed as in a terminal. JupyterLab's own Python imports this.

``_get_os_path`` is private: checked with jupyter_server 2.21.
"""
import os

from jupyter_server.services.contents.largefilemanager import AsyncLargeFileManager
from tornado.web import HTTPError

from course_page.typed_paths import below


class HomeContents(AsyncLargeFileManager):
    """The files below ``root_dir``."""

    def _get_os_path(self, path: str) -> str:
        try:
            return super()._get_os_path(below(os.path.abspath(self.root_dir), path))
        except ValueError as error:
            raise HTTPError(404, str(error)) from None
