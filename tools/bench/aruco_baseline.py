"""The baseline: OpenCV's ArUco detector on ALVAR's markers, with a dictionary of the ids 0 to 255."""
import cv2
import numpy as np

from alvar_core import code, drawing, rotations

MARGIN = 2  # cells


def dictionary():
    """Return ALVAR's 5x5 numbers as an ArUco dictionary that corrects one wrong cell."""
    words = [cv2.aruco.Dictionary.getByteListFromBits(code.encode(number).astype(np.uint8)) for number in range(256)]
    return cv2.aruco.Dictionary(np.concatenate(words), 5, 1)


class ArucoBaseline:
    """A detector with sub-pixel corners that takes the pose of IPPE_SQUARE with the smaller reprojection error."""

    def __init__(self):
        parameters = cv2.aruco.DetectorParameters()
        parameters.markerBorderBits = MARGIN
        parameters.errorCorrectionRate = 1.0
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(dictionary(), parameters)

    def detect(self, image, camera, size):
        """Return the detections of markers ``size`` [m] wide: id, position [m], orientation x y z w, corners."""
        corners, ids, _ = self._detector.detectMarkers(image)
        return [record for quad, number in zip(corners, [] if ids is None else ids.ravel().tolist())
                for record in self.pose(number, quad.reshape(4, 2).astype(float), camera, size)]

    @staticmethod
    def pose(number, corners, camera, size):
        """Return the detection of a marker with these corners (4, 2) [px] in a list; none if it has no pose."""
        good, turns, shifts, _ = cv2.solvePnPGeneric(drawing.object_corners(size), corners, camera.matrix,
                                                     camera.distortion, flags=cv2.SOLVEPNP_IPPE_SQUARE)
        if not good or not np.isfinite(shifts[0]).all():
            return []
        return [{'id': number, 'position': shifts[0].ravel().tolist(), 'corners': corners.tolist(),
                 'orientation': rotations.quaternion_from_matrix(cv2.Rodrigues(turns[0])[0]).tolist()}]
