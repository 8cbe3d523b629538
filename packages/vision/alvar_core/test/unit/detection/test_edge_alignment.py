"""Flat and curved markers are moved onto the edges of their cells."""
import cv2
import numpy as np
import pytest

from alvar_core.camera import default_camera
from alvar_core.detection import homography
from alvar_core.detection.bent_paper import Crease, Cylinder
from alvar_core.detection.edge_alignment import changed, edge_points, fit_plane, scale_of
from alvar_core.detection.light import LINEAR

BLACK = np.array([[True, False, True], [True, True, True], [False, True, True]])
CYLINDER, CREASE = Cylinder(default_camera(), 3), Crease(default_camera(), 3)
EDGES = edge_points(BLACK, np.array([-0.25, 0.25]))
POSE = [2.9, 0.3, -0.4, 0.2, -0.1, 6.0]  # rotation vector, position [widths]


@pytest.mark.parametrize('model, theta', [(CYLINDER, [*POSE, 0.5, 0.8]), (CYLINDER, [*POSE, -0.4, 2.0]),
                                          (CREASE, [*POSE, 0.2, 0.8, 0.15]), (CREASE, [*POSE, -0.3, 4.0, 0.1])])
def test_curved_marker_is_moved_onto_its_edges(model, theta):
    """The image is drawn at eight times the size, cell by cell, by the places of a fine grid."""
    image, fine, line = np.full((480 * 8, 640 * 8), 200, np.uint8), 30, np.linspace(-1.5, 1.5, 91)
    grid = np.stack(np.meshgrid(line, line), -1).reshape(-1, 2)
    at = np.round(8 * (model.places(np.array(theta), grid) + 0.5) - 0.5).astype(np.int32).reshape(91, 91, 2)
    for row, column in np.argwhere(np.kron(BLACK, np.ones((fine, fine)))):
        cv2.fillConvexPoly(image, at[[row, row, row + 1, row + 1], [column, column + 1, column + 1, column]], 30)
    image = cv2.resize(image, (640, 480), interpolation=cv2.INTER_AREA)
    start = np.array(theta) + [0.02, -0.02, 0.03, 0.004, -0.004, 0.05, -0.1, *np.full(len(theta) - 7, 0.05)]
    fit = model.fit(image, start[None], EDGES, len(theta), 3.0, 6, 5.0, LINEAR)[0]
    assert fit.seen > 0.9 and fit.error < 0.1  # px
    corners = 1.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    assert np.abs(model.places(fit.parameters, corners) - model.places(np.array(theta), corners)).max() < 0.3  # px
    assert fit.parameters[:3] == pytest.approx(theta[:3], abs=0.03)  # rad
    assert fit.parameters[6] == pytest.approx(theta[6], abs=0.03)
    assert np.linalg.eigvalsh(fit.covariance).min() > 0


def test_flat_marker_is_moved_onto_its_edges():
    image = np.kron(np.where(np.pad(BLACK, 2), 30, 200), np.ones((20, 20))).astype(np.uint8)
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    right = np.array([[39.5, 39.5], [99.5, 39.5], [99.5, 99.5], [39.5, 99.5]])
    off = right + [[1, -0.5], [0, 1], [-1, 0.5], [0.5, 0]]
    h = homography.from_square(off[None], 1.5)[0]
    fit = fit_plane(image, default_camera(140, 140), h, EDGES, scale_of(1.5), 3.0, 4)
    corners = homography.apply(changed(h, fit.parameters)[None], 1.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))
    assert np.abs(corners[0] - right).max() < 0.1 and fit.seen > 0.9  # px
    assert np.linalg.eigvalsh(fit.covariance).min() > 0


def test_strip_as_bright_as_what_lies_beyond_is_no_edge():
    """Black, 3 px white, dark: the ends of the profile differ little, and the step would be far beyond it."""
    image = np.full((120, 120), 25, np.uint8)
    image[27:93, 27:93] = 180
    image[30:90, 30:90] = 18
    points = edge_points(np.ones((3, 3), bool), np.array([-0.3, 0.0, 0.3]))
    h = homography.from_square(np.array([[[29.5, 29.5], [89.5, 29.5], [89.5, 89.5], [29.5, 89.5]]]), 1.5)[0]
    fits = [fit_plane(image, default_camera(120, 120), h, points, np.full(8, 1e-3), reach, 1) for reach in (4.0, 1.2)]
    assert [each is not None for each in fits] == [False, True]  # 6.4 px and 1.9 px are read
