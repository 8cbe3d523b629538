"""What makes a marker of an aligned candidate."""
from collections import namedtuple

# Asked of every candidate: fit (of the data cells with the code word), surplus (gap to the next best word in parts of
# what the best leaves unexplained), detail (likeness of the cells without anything smooth); noise counts against none
# of them.  More is asked where the likeness (correlation of the whole drawing) is low or cells are covered.
Demand = namedtuple('Demand', 'fit surplus detail')
CLEAR, UNLIKE = Demand(0.87, 0.55, 0.83), Demand(0.86, 0.85, 0.86)
COVERED, CODE_COVERED = Demand(0.86, 0.9, 0.78), Demand(0.86, 0.7, 0.78)
CLEAR_LIKENESS, MIN_GAP, WIDE_GAP = 0.88, 0.03, 0.1
MIN_KEPT = 0.7  # share of the samples that agree with the drawing
MAX_RIM = 6  # cells of the rim that do not
# Of the contrast: darker than paper, all along a side, it is a part of something larger, but for a high likeness.
MIN_OUTSIDE, WHOLE_LIKENESS = -0.3, 0.92


def accepted(f):
    """Whether a candidate with these features (Detector._features) is a marker."""
    if f['bad_inside'] >= 2 and f['gap'] > WIDE_GAP:
        asked = CODE_COVERED
    elif f['bad_rim'] + 2 * f['bad_inside'] >= 3:
        asked = COVERED
    else:
        asked = CLEAR if f['likeness'] > CLEAR_LIKENESS else UNLIKE
    surplus = f['gap'] / (1.03 - min(f['fit'], 1.0))
    return (f['gap'] > MIN_GAP and f['kept'] > MIN_KEPT and f['bad_rim'] <= MAX_RIM
            and (f['outside'] > MIN_OUTSIDE or f['likeness'] > WHOLE_LIKENESS)
            and f['fit'] > asked.fit and surplus > asked.surplus and f['detail'] > asked.detail)
