"""The folders of ROS packages, as rospack finds them. Without ROS."""
import functools
import pathlib


@functools.lru_cache(maxsize=None)
def folder(name: str) -> pathlib.Path:
    """Return the folder of a package. Raise rospkg.ResourceNotFound."""
    import rospkg  # pip installs this package without it
    return pathlib.Path(rospkg.RosPack().get_path(name))
