"""Compares a picture that a simulator saved with the one on the page: the paths that are drawn, not the turtles."""
import cv2
import numpy as np

REACH = 3  # [px] that a path may lie elsewhere; the turtle stops within 5 mm, a fifth of a pixel, and turns on the spot
SHARE = 0.97  # of the path that must be there, in both directions


def differences(page, saved):
    """Return what the saved picture shows otherwise than the page's, or an empty text; both are BGR arrays."""
    if page.shape != saved.shape:
        return f'its size is {saved.shape[1]} x {saved.shape[0]} px, on the page {page.shape[1]} x {page.shape[0]} px'
    ground = _ground(page)
    if ground != _ground(saved):
        return 'the background is another one'
    colours = path_colours(page, ground)
    for colour in sorted(colours | path_colours(saved, ground)):
        for one, other, text in ((page, saved, 'lacks'), (saved, page, 'has beyond the page')):
            share = _share(one, other, colour, ground)
            if share < SHARE:
                return f'it {text} {100.0 * (1.0 - share):.0f} % of the path in RGB {colour[::-1]}'
    return ''


def _ground(picture):
    return tuple(picture[0, 0].tolist())


def path_colours(picture, ground):
    """Return the colours, BGR, of long lines: such as many pixels have and no turtle (green) has."""
    colours, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    return {tuple(colour.tolist()) for colour, count in zip(colours, counts)
            if count > 150 and tuple(colour.tolist()) != ground and not colour[1] > max(colour[0], colour[2]) + 20}


def _share(one, other, colour, ground):
    """Return the share of a colour's pixels in ``one`` near which ``other`` has it, or a turtle that may cover it."""
    mine = np.all(one == colour, axis=2)
    if not mine.any():
        return 1.0
    plain = np.all(other == ground, axis=2)
    reach = np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)
    covered = cv2.dilate((~plain).astype(np.uint8), reach) > 0
    return float((mine & covered).sum() / mine.sum())
