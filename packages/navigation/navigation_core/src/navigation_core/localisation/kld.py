"""KLD-sampling: how many particles are needed."""
import numpy as np

from navigation_core.poses import Array


def entropy_limit(bins: Array, error: float, quantile: float) -> Array:
    """Return the number of particles with which the distribution over ``bins`` is off by at most ``error``.

    This holds with the probability whose quantile of the normal distribution is ``quantile`` (Fox, KLD-sampling).
    """
    bins = np.maximum(bins, 2)
    share = 2.0 / (9.0 * (bins - 1))
    return np.asarray(np.ceil((bins - 1) / (2.0 * error) * (1.0 - share + np.sqrt(share) * quantile) ** 3))
