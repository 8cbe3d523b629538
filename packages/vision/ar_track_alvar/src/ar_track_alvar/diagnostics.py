"""Statistics of the tracker for /diagnostics."""
import statistics

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue


class Statistics:
    """Counts dropped images and markers without transform since the start, everything else since the last report."""

    def __init__(self):
        self.skipped = self.dropped = self.refused = self.missing_transforms = 0
        self._begin_second()

    def _begin_second(self):
        self._found = self._ambiguous = self._bent = self._doubtful = 0
        self._times, self._latencies, self._trouble = [], [], ''

    def searched(self, seconds, detections):
        """Count an image that was searched in ``seconds``, with its Detections."""
        self._times.append(seconds)
        self._found += len(detections)
        self._ambiguous += sum(d.ambiguous for d in detections)
        self._bent += sum(d.bend != 0 for d in detections)
        self._doubtful += sum(d.doubtful for d in detections)

    def published(self, seconds):
        """Count a message that was published ``seconds`` after its image arrived."""
        self._latencies.append(seconds)

    def trouble(self, text):
        """Note why poses are missing."""
        self._trouble = text

    def report(self, name, elapsed, enabled, stamp, more=None):
        """Return the DiagnosticArray of the last ``elapsed`` [s] of the node ``name``, and start the next period.

        ``more`` {key: value} adds values to it.
        """
        pictures = len(self._times)
        said = self._trouble or (f'{pictures / elapsed:.1f} images per second' if enabled else 'disabled')
        values = {
            'rate [Hz]': f'{pictures / elapsed:.2f}', 'time per image [ms]': _median_ms(self._times),
            'time from image to message [ms]': _median_ms(self._latencies),
            'markers per image': f'{self._found / max(pictures, 1):.2f}',
            'markers with ambiguous orientation': self._ambiguous, 'markers on bent paper': self._bent,
            'markers with doubtful orientation': self._doubtful, 'markers without transform': self.missing_transforms,
            'images refused': self.refused, 'images dropped': self.dropped,
            'images beyond max_frequency': self.skipped, 'enabled': enabled, **(more or {})}
        status = DiagnosticStatus(level=DiagnosticStatus.WARN if self._trouble else DiagnosticStatus.OK,
                                  name=f'{name.lstrip("/")}: markers', message=said, hardware_id='none',
                                  values=[KeyValue(key, str(value)) for key, value in values.items()])
        report = DiagnosticArray(status=[status])
        report.header.stamp = stamp
        self._begin_second()
        return report


def _median_ms(seconds):
    return f'{1000.0 * statistics.median(seconds):.2f}' if seconds else 'none'
