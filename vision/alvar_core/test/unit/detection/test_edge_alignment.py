"""The models of a marker in the image: where its edges are, which way they face, and how parameters move them."""
import cv2
import numpy as np
import pytest

from alvar_core.camera import default_camera
from alvar_core.detection import homography
from alvar_core.detection.bent_paper import Crease, Cylinder
from alvar_core.detection.edge_alignment import changed, edge_points, fit_plane, scale_of

BLACK = np.array([[True, False, True], [True, True, True], [False, True, True]])
CYLINDER, CREASE = Cylinder(default_camera(), 3), Crease(default_camera(), 3)
POSE = [2.9, 0.3, -0.4, 0.2, -0.1, 6.0]  # rotation vector, position [widths]


@pytest.mark.parametrize('model, place, starts', [
    (CYLINDER, CYLINDER.places, [[*POSE, 0.0, 0.0], [*POSE, 0.5, 0.8], [*POSE, -0.4, 2.0]]),
    (CREASE, CREASE.places, [[*POSE, 0.2, 0.8, 0.15], [*POSE, -0.3, 4.0, 0.1]]),
], ids=['cylinder', 'crease'])
def test_edges_of_a_model(model, place, starts):
    points, theta, small = edge_points(BLACK, np.array([-0.3, 0.2])), np.array(starts), 1e-6
    seen = model.edges(theta, points)
    at = place(theta, points.middle).transpose(0, 2, 1)
    assert seen.at == pytest.approx(at)
    along = place(theta, points.middle + small * points.outward[:, ::-1]).transpose(0, 2, 1) - at
    outward = place(theta, points.middle + small * points.outward).transpose(0, 2, 1) - at
    assert (seen.direction * along).sum(1) / small == pytest.approx(0, abs=1e-2)  # px, of 20 to 30 for a cell
    assert (seen.direction * outward).sum(1).min() > 0
    assert (seen.direction ** 2).sum(1) == pytest.approx(1)
    for k in range(theta.shape[1]):
        moved = place(theta + small * (np.arange(theta.shape[1]) == k), points.middle).transpose(0, 2, 1) - at
        # derivatives by bend and axis are differences: 0.2 px in some tens
        assert seen.jacobian[:, k] == pytest.approx((moved * seen.direction).sum(1) / small, abs=0.2, rel=0.01)


EDGES = edge_points(BLACK, np.array([-0.25, 0.25]))


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
