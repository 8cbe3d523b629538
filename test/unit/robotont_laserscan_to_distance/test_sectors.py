"""robotont_laserscan_to_distance.core.sectors: thirds of a scan, from right to left."""
import math

import pytest

from robotont_laserscan_to_distance.core.sectors import Sector, Sectors, split

NOTHING = Sector(math.nan, math.nan)


@pytest.mark.parametrize('ranges, expected', [
    ((1, 3, 2, 4, 5, 7), Sectors(Sector(1, 2), Sector(2, 3), Sector(5, 6))),
    ((1, 2, 3, 4), Sectors(Sector(1, 1), Sector(2, 2), Sector(3, 3.5))),  # what is left over belongs to the left
    ((math.nan, 2, math.inf, 4, math.inf, math.nan), Sectors(Sector(2, 2), Sector(4, 4), Sector(math.inf, math.nan))),
    ((), Sectors(NOTHING, NOTHING, NOTHING)),
    ((math.nan,) * 3, Sectors(NOTHING, NOTHING, NOTHING)),
])
def test_sectors(ranges, expected):
    for found, sector in zip(split(ranges), expected):
        assert found == pytest.approx(sector, nan_ok=True)
