"""A turtle in the real core, driven as a student's node would drive it, observed as the grader observes it."""
from course_grader.rules.observation import Command, Event, Observed, OutputLine, Sample
from kinematic_core.worlds.turtle_world import DT, TurtleWorld


class GradedTurtle:
    """turtle1 of a TurtleWorld, which appends its motion to ``observed``."""

    def __init__(self, x=5.5, y=5.5, theta=0.0):
        self.world = TurtleWorld()
        self.observed = Observed()
        self.world.teleport_absolute('turtle1', x, y, theta)
        self._tick()

    @property
    def t(self):
        """Seconds since the begin."""
        return self.world.steps * DT

    def _tick(self):
        self.world.step()
        turtle = self.world.turtles['turtle1']
        pose = turtle.pose()
        self.observed.track.append(Sample(self.t, pose.x, pose.y, pose.theta))
        self.observed.seconds = self.t

    def drive(self, seconds, linear=0.0, angular=0.0, rate=10.0, say=None):
        """Send a velocity [m/s, rad/s] ``rate`` times a second; ``say(pose)`` returns a line to print with it."""
        end, due = self.t + seconds, self.t
        while self.t < end - 1e-9:
            if self.t >= due - 1e-9:
                due += 1.0 / rate
                self.world.command('turtle1', linear, 0.0, angular)
                self.observed.commands.append(Command(self.t, linear, 0.0, angular, '/student'))
                if say:
                    self.print(say(self.observed.track[-1]))
            self._tick()
        return self

    def wait(self, seconds):
        """Do nothing."""
        end = self.t + seconds
        while self.t < end:
            self._tick()
        return self

    def print(self, text):
        """Print a line, or several."""
        self.observed.lines.extend(OutputLine(self.t, line) for line in text.split('\n'))
        return self

    def teleport(self, x, y, theta=0.0):
        """Call teleport_absolute."""
        self.world.teleport_absolute('turtle1', x, y, theta)
        self.observed.events.append(Event(self.t, 'teleport', (x, y, theta), '/student'))
        self._tick()
        return self

    def pen(self, *values):
        """Call set_pen with r, g, b, width, off."""
        self.observed.events.append(Event(self.t, 'pen', values, '/student'))
        return self

    def jump(self, linear, angular):
        """Call teleport_relative."""
        self.world.teleport_relative('turtle1', linear, angular)
        pose = self.world.turtles['turtle1'].pose()
        self.observed.events.append(Event(self.t, 'teleport_relative', (pose.x, pose.y, pose.theta), '/student'))
        self._tick()
        return self

    def reset(self):
        """Call reset: the turtle is in the middle, and the drawing is gone."""
        self.world.reset()
        self._tick()
        self.observed.events.append(Event(self.t, 'reset', (), '/student'))
        return self
