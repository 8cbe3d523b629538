"""findMarkerBundles: publish the poses of bundles in the coloured point clouds of a depth camera."""
from alvar_core.detection import depth
from ar_track_alvar import bundle_node, settings, start
from ar_track_alvar.core import command_line
from ar_track_alvar.core.filters import MedianPose
from ar_track_alvar.depth_node import DEPTH_NOISE, INPUT, DepthInput
from rospy_support.parameters import Integer, Table

EXAMPLE = f'{command_line.DEPTH_EXAMPLE} _bundle_files:="FILE.xml OTHER.xml"'

MEDIAN = Integer('~med_filt_size', 0, 0, 100)
PARAMETERS = Table(bundle_node.BUNDLE_FILES, INPUT, DEPTH_NOISE, MEDIAN)


class DepthBundleNode(DepthInput, bundle_node.BundleNode):
    """Publishes bundles; the pose is the most central one of the last ``median`` poses (0: the last pose)."""

    def __init__(self, read, known, noise, median):
        self.noise, self._median = noise, {bundle.source: MedianPose(median) for bundle in known} if median > 1 else {}
        super().__init__(read, known)

    def found_bundles(self, detections):
        """Return the BundlePoses that fit corners and planes of all markers of the bundles."""
        found = super().found_bundles(detections)
        for one in found:
            seen = [each for each in detections if each.id in one.used]
            if any(each in self.planes for each in seen):
                observations = [depth.observed(each, one.bundle.corners[each.id], self.camera,
                                               self.planes.get(each)) for each in seen]
                best = depth.fitted(observations, one.rotation, one.position, self.camera)
                one.rotation, one.position, one.error = best.rotation, best.position, best.error
            if one.bundle.source in self._median:
                one.rotation, one.position = self._median[one.bundle.source].add(one.rotation, one.position)
        return found


def main():
    """Run findMarkerBundles."""
    start.init_node('findMarkerBundles', PARAMETERS, command_line.DEPTH_BUNDLE_USAGE,
                    command_line.depth_bundle_arguments, EXAMPLE)
    known = bundle_node.read_bundles(bundle_node.BUNDLE_FILES.read())
    DepthBundleNode(settings.read(PARAMETERS), known, DEPTH_NOISE.read(), MEDIAN.read()).run()
