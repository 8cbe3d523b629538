"""The turtles' world together with its canvas: motion, strokes and colour sensors in turtlesim's order."""
from kinematic_core.turtle_world import BACKGROUND, START, WATCHDOG_STEPS, TurtleWorld
from turtlesim.canvas import Canvas


class DrawnWorld:
    """A TurtleWorld whose strokes are drawn. Not thread-safe: whoever shares it between threads locks it."""

    def __init__(self, background=BACKGROUND, watchdog_steps=WATCHDOG_STEPS, start=START):
        """Begin with turtle1 at ``start`` on a canvas of the colour ``background``, (r, g, b) 0..255."""
        self.world = TurtleWorld(watchdog_steps, start)
        self.canvas = Canvas(background)

    def reset(self, background=BACKGROUND):
        """Begin anew: turtle1 alone on an empty canvas."""
        self.world.reset()
        self.canvas.fill(background)

    def step(self):
        """Let one step pass; return (turtle, colour under it, wall) for each turtle in alphabetical order.

        The colour, (r, g, b), is read after the step's teleports have drawn and before its motion has; ``wall`` is
        None or the (x, y_down) [m] that was clamped.
        """
        canvas = self.canvas
        readings = []
        for turtle, teleports, wall, stroke in self.world.step():
            for teleport in teleports:
                canvas.draw(teleport)
            readings.append((turtle, canvas.color_at(turtle.x, turtle.y_down), wall))
            if stroke is not None:
                canvas.draw(stroke)
        return readings
