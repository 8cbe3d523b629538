"""Change settings while the node runs, with dynamic_reconfigure."""
import math
import xmlrpc.client

import rosgraph
import rospy
from dynamic_reconfigure.server import Server

from ar_track_alvar.cfg import ParamsConfig


class LiveSettings:
    """Lets dynamic_reconfigure change a Settings; calls ``on_change()`` after every change, in rospy's threads."""

    def __init__(self, settings, on_change):
        self._settings, self._on_change = settings, on_change
        for name in ParamsConfig.defaults:  # as floats, because dynamic_reconfigure treats whole numbers as int
            rospy.set_param(f'~{name}', getattr(settings, name))
        self._server = Server(ParamsConfig, self._changed)

    def enable(self, enabled):
        """Switch detection on or off, and tell the clients of dynamic_reconfigure."""
        self._update({'enabled': bool(enabled)})

    def restore(self):
        """Set the parameters again on a restarted master."""
        self._update({})

    def _update(self, changes):
        try:
            self._server.update_configuration(changes)
        except (OSError, rosgraph.MasterException, xmlrpc.client.Error) as error:  # the change still takes effect
            rospy.logwarn('Cannot write a change to the parameter server: %s', error)

    def _changed(self, config, _):
        for name in ParamsConfig.defaults:
            if not math.isfinite(config[name]):
                rospy.logwarn('dynamic_reconfigure: %s is %s; it must be a finite number; it stays %s', name,
                              config[name], getattr(self._settings, name))
                config[name] = getattr(self._settings, name)
            setattr(self._settings, name, config[name])
        self._on_change()
        return config
