"""Where packages are: for $(find PACKAGE) in xacro files."""
import rospkg


class PackageNotFoundError(KeyError):
    """There is no such package."""

    def __str__(self):
        return (f"there is no package '{self.args[0]}' on the ROS_PACKAGE_PATH; is it built, and has this terminal "
                'sourced the setup.bash of its workspace?')


def get_package_share_directory(package):
    """Return the folder of a package's package.xml; raise PackageNotFoundError if rospack finds none."""
    try:
        return rospkg.RosPack().get_path(package)
    except rospkg.ResourceNotFound:
        raise PackageNotFoundError(package) from None
