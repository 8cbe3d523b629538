"""Compares a picture that a simulator saved with the one on the page: the paths that are drawn, not the turtles."""
import cv2
import numpy as np

REACH = 3  # [px] that a path may lie elsewhere; a drive that stops within 2 cm is 1 px off
SHARE = 0.97  # of the path that must be there, in both directions
LONG = 150  # [px] of one colour that are a path
GREENER = 20  # than red and blue: of a turtle


def differences(page, saved):
    """Return how the saved picture differs from the one on the page, or an empty text; both are BGR arrays."""
    if page.shape != saved.shape:
        return f'its size is {saved.shape[1]} x {saved.shape[0]} px, on the page {page.shape[1]} x {page.shape[0]} px'
    page, saved = _numbered(page), _numbered(saved)
    ground = page[0, 0]
    if saved[0, 0] != ground:
        return 'the background is another one'
    paths = _paths(page, ground) | _paths(saved, ground)
    for colour in sorted(paths):
        for one, other, text in ((page, saved, 'lacks'), (saved, page, 'has beyond the page')):
            share = _share(one == colour, (other == colour) | ~np.isin(other, [ground, *paths]))
            if share < SHARE:
                return f'it {text} {100.0 * (1.0 - share):.0f} % of the path in the colour #{colour:06x}'
    return ''


def differences_of_canvas(page, canvas):
    """Return the same for what a turtlesim has drawn without its turtles."""
    if page.shape != canvas.shape:
        return differences(page, canvas)
    shown, drawn = _numbered(page), _numbered(canvas)
    known = [drawn[0, 0], *_paths(drawn, drawn[0, 0])]
    if len(known) == 1:
        return 'nothing is drawn'
    return differences(np.where(np.isin(shown, known)[:, :, None], page, canvas), canvas)


def _numbered(picture):
    """Return an array of one number 0xRRGGBB for each pixel."""
    return picture.astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], np.int32)


def _paths(picture, ground):
    """Return the colours of which there is much, except the background and the green of turtles."""
    colours, counts = np.unique(picture, return_counts=True)
    return {int(colour) for colour, count in zip(colours, counts) if count > LONG and colour != ground
            and (colour >> 8 & 255) <= max(colour >> 16, colour & 255) + GREENER}


def _share(mine, theirs):
    """Return the share of the pixels ``mine`` that have one of ``theirs``, the path or a turtle on it, within REACH."""
    near = cv2.dilate(theirs.astype(np.uint8), np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)) > 0
    return float((mine & near).sum() / mine.sum()) if mine.any() else 1.0
