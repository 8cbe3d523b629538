"""kinematic_core.worlds.sectors: thirds of a scan, from right to left."""
import math
import re

import pytest

from kinematic_core.worlds.sectors import SCAN_HEIGHT, Sector, Sectors, floor_depth, split
from unit_support.packages import PACKAGES

PACKAGE = PACKAGES['robotont_laserscan_to_distance'].folder
NOTHING = Sector(math.nan, math.nan)


@pytest.mark.parametrize('ranges, expected', [
    ((1, 3, 2, 4, 5, 7), Sectors(Sector(1, 2), Sector(2, 3), Sector(5, 6))),
    ((1, 2, 3, 4), Sectors(Sector(1, 1), Sector(2, 2), Sector(3, 3.5))),  # the rest belongs to the left
    ((math.nan, 2, math.inf, 4, math.inf, math.nan), Sectors(Sector(2, 2), Sector(4, 4), Sector(math.inf, math.nan))),
    ((), Sectors(NOTHING, NOTHING, NOTHING)),
    ((math.nan,) * 3, Sectors(NOTHING, NOTHING, NOTHING)),
])
def test_sectors(ranges, expected):
    for found, sector in zip(split(ranges), expected):
        assert found == pytest.approx(sector, nan_ok=True)


def test_the_scan_has_the_height_of_the_launch_file():
    settings = (PACKAGE / 'config' / 'laser_params.yaml').read_text(encoding='utf-8')
    assert re.findall(r'^scan_height: (.*?) +#', settings, re.MULTILINE) == [str(SCAN_HEIGHT)]


def test_where_the_floor_begins():
    """100 rows below the horizon of a camera 0.2 m high, at 500 px: a slope of 100 / 500, so 0.2 / 0.2 = 1 m."""
    assert floor_depth(0.2, 500.0) == pytest.approx(1.0)
