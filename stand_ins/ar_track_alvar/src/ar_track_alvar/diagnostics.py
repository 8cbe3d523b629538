"""What the tracker says about itself once a second on /diagnostics."""
import statistics

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue


class Statistics:
    """Counts since the last report, and since the start."""

    def __init__(self):
        self.skipped = self.dropped = self.refused = self.missing_transforms = 0  # since the start
        self.trouble = ''  # the newest reason why there are no poses
        self._begin_second()

    def _begin_second(self):
        self.detections, self.ambiguous, self.times, self.latencies = 0, 0, [], []

    def picture(self, seconds, detections):
        """Count a picture that was searched in so many ``seconds``, with its Detections."""
        self.times.append(seconds)
        self.detections += len(detections)
        self.ambiguous += sum(d.ambiguous for d in detections)

    def report(self, elapsed, name, stamp, values=()):
        """Return the DiagnosticArray of the last ``elapsed`` [s]; ``values``: further (key, text)."""
        ms = 1000.0 * statistics.median(self.times) if self.times else 0.0
        latency = 1000.0 * statistics.median(self.latencies) if self.latencies else 0.0
        pictures = len(self.times)
        status = DiagnosticStatus(level=DiagnosticStatus.WARN if self.trouble else DiagnosticStatus.OK,
                                  name=f'{name}: markers', hardware_id='none',
                                  message=self.trouble or f'{pictures / elapsed:.1f} pictures a second')
        status.values = [KeyValue(key, str(value)) for key, value in (
            ('rate [Hz]', f'{pictures / elapsed:.2f}'), ('time per picture [ms]', f'{ms:.2f}'),
            ('from arrival to message [ms]', f'{latency:.2f}'),
            ('markers per picture', f'{self.detections / pictures if pictures else 0.0:.2f}'),
            ('markers with ambiguous orientation', self.ambiguous), ('pictures refused', self.refused),
            ('pictures beyond max_frequency', self.skipped), ('pictures dropped', self.dropped),
            ('markers without transform', self.missing_transforms), *values)]
        report = DiagnosticArray(status=[status])
        report.header.stamp = stamp
        self._begin_second()
        self.trouble = ''
        return report
