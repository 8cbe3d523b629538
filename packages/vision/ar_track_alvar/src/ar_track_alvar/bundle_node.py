"""findMarkerBundlesNoKinect: publish one pose for each bundle, a set of markers that are fixed to each other."""
import os
import shlex

import rospy

from alvar_core import bundles, code
from alvar_core.detection.bundle_pose import BundleTracker
from ar_track_alvar import conversions, settings, start
from ar_track_alvar.conversions import MarkerPose
from ar_track_alvar.core import command_line
from ar_track_alvar.node import MarkerNode
from rospy_support import parameters

MASTER, OTHERS = ('main_shapes', (1.0, 0.0, 0.0, 1.0)), ('basic_shapes', (0.0, 1.0, 0.0, 0.7))  # in rviz
MIRRORED = code.mirrored_numbers()
ODD_PICTURES = 5  # consecutive images in which a marker contradicts its bundle, before a warning
EXAMPLE = f'{command_line.EXAMPLE} _bundle_files:="FILE.xml OTHER.xml"'

BUNDLE_FILES = parameters.Text('~bundle_files', '')
PARAMETERS = parameters.Table(BUNDLE_FILES, settings.PARAMETERS)


class BundleNode(MarkerNode):
    """Publishes the poses of bundles under the ids of their masters, and single markers only for rviz."""

    def __init__(self, settings, known):
        """``known`` are the alvar_core.bundles.Bundles to search for."""
        super().__init__(settings, sizes_of(known))
        self._bundles, self._known = BundleTracker(known), known
        self._masters = {bundle.master for bundle in known}
        self._odd = {}  # (source, id) of a marker: consecutive images in which it contradicted its bundle

    def to_publish(self, detections):
        """Return the MarkerPoses of the bundles with a detected marker and, for rviz only, those of other markers."""
        found = self.found_bundles(detections)
        self._notice_odd(found)
        self._notice_mirrored(detections)
        others = [self._marker_pose(d.id, d, False, OTHERS) for d in detections if d.id not in self._masters]
        return others + [self._marker_pose(one.bundle.master, one, True, MASTER) for one in found]

    def _notice_mirrored(self, detections):
        """Warn if the markers seen are in no bundle, but their mirror images are."""
        seen = sorted({d.id for d in detections if d.id in range(len(MIRRORED))})
        known = {number for bundle in self._known for number in bundle.ids}
        if len(seen) > 1 and not known.intersection(seen) and known.issuperset(MIRRORED[number] for number in seen):
            self.complain('mirrored', f'The markers {_listed(seen)} are in no bundle, but their mirror images '
                          f'{_listed(MIRRORED[number] for number in seen)} are: is the image mirrored, as some webcams '
                          'show it? Switch that off in the driver')

    def found_bundles(self, detections):
        """Return the BundlePoses of the bundles with a marker among the Detections of the next image."""
        return self._bundles.update(detections, self.camera)

    def _marker_pose(self, number, found, reported, look):
        return MarkerPose(number, found.rotation, found.position, conversions.confidence(found), self.size_of(number),
                          reported, *look)

    def _notice_odd(self, found):
        """Warn about markers that are not where the file of their bundle says."""
        odd = {(one.bundle.source, number) for one in found for number in set(one.rejected) - set(one.used)}
        self._odd = {key: self._odd.get(key, 0) + 1 for key in odd}
        for (source, number), pictures in self._odd.items():
            if pictures >= ODD_PICTURES:
                self.complain(('odd', source, number), f'Marker {number} is not where {source} says (or has another '
                              'size); it is ignored. Was it moved, or is there a second one with this number?')


def _listed(numbers):
    return ', '.join(map(str, numbers))


def sizes_of(known):
    """Return {id: width of the square [m]} of all markers; the first bundle that contains a marker counts."""
    sizes = {}
    for bundle in known:
        sizes.update({number: size for number, size in bundle.sizes.items() if number not in sizes})
    return sizes


def read_bundles(names):
    """Return the Bundles in files (names separated by spaces, quoted as in a shell); log their peculiarities."""
    try:
        paths = shlex.split(names)
    except ValueError as error:
        raise _wrong(f'is {names!r}: {error}; quote names with spaces as in a shell') from None
    if not paths:
        raise _wrong('must be set: the XML files of the bundles, separated by spaces; the folder bundles of this '
                     'package contains some, and createMarker writes such files')
    try:
        known = [bundles.read(os.path.abspath(path)) for path in paths]
    except bundles.BundleError as error:
        raise _wrong(f'is {names!r}: {error}') from None
    for bundle in known:
        sizes = sorted(set(f'{100 * size:.3g}' for size in bundle.sizes.values()))
        rospy.loginfo('Bundle %d of %s: markers %s, %s cm wide', bundle.master, bundle.source,
                      ' '.join(map(str, bundle.ids)), ', '.join(sizes))
        for note in bundle.notes:
            rospy.logwarn('Bundle file %s: %s', bundle.source, note)
    _note_shared(known)
    return known


def _note_shared(known):
    owners = {}
    for bundle in known:
        for number in bundle.ids:
            owners.setdefault(number, []).append(bundle.source)
    for number, sources in owners.items():
        if len(sources) > 1:
            rospy.logwarn('Marker %d belongs to %s; it counts for each of them. Use each marker '
                          'in one bundle only', number, ' and '.join(sources))


def _wrong(text):
    return parameters.ParameterError(f'parameter {rospy.resolve_name(BUNDLE_FILES.name)} {text}')


def main():
    """Run findMarkerBundlesNoKinect."""
    start.init_node('findMarkerBundlesNoKinect', PARAMETERS, command_line.BUNDLE_USAGE, command_line.bundle_arguments,
                    EXAMPLE)
    known = read_bundles(BUNDLE_FILES.read())
    BundleNode(settings.read(), known).run()
