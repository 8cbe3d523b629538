"""How many particles are enough: KLD-sampling."""
import math

import numpy as np

from navigation_core.poses import Array


def entropy_limit(bins: Array, error: float, quantile: float) -> Array:
    """Return how many particles occupied bins need, so that their distribution is off by at most ``error``.

    The limit of Fox, KLD-sampling: with the probability whose quantile of the normal distribution is ``quantile``.
    """
    bins = np.maximum(bins, 2)
    share = 2.0 / (9.0 * (bins - 1))
    return np.asarray(np.ceil((bins - 1) / (2.0 * error) * (1.0 - share + np.sqrt(share) * quantile) ** 3))


def quantile_of(probability: float) -> float:
    """Return the quantile of the normal distribution: amcl's kld_z is the probability, mostly 0.99."""
    low, high = 0.0, 8.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 0.5 * (1.0 + math.erf(middle / math.sqrt(2.0))) < probability else (low, middle)
    return low
