"""The turtles' world together with its canvas: motion, strokes and colour sensors in turtlesim's order."""
from typing import List, NamedTuple, Optional, Tuple

from kinematic_core.worlds.turtle_world import BACKGROUND, START, WATCHDOG_STEPS, Colour, Turtle, TurtleWorld
from turtlesim.core.canvas import Canvas


class Reading(NamedTuple):
    """The readings of one turtle after a step: the colour under it, and where (x, y_down) [m] it hit a wall, or None.

    The colour is read after the teleports of the step are drawn, and before its motion is.
    """

    turtle: Turtle
    colour: Colour
    wall: Optional[Tuple[float, float]]


class DrawnWorld:
    """A TurtleWorld whose strokes are drawn. Not thread-safe: threads that share it need a lock."""

    def __init__(self, background: Colour = BACKGROUND, watchdog_steps: float = WATCHDOG_STEPS,
                 start: Tuple[float, float, float] = START) -> None:
        """Start with turtle1 at ``start`` (x, y [m], theta [rad]) on a canvas of one colour, (r, g, b) 0..255."""
        self.world = TurtleWorld(watchdog_steps, start)
        self.canvas = Canvas(background)

    def reset(self, background: Colour = BACKGROUND) -> None:
        """Start again: turtle1 alone on an empty canvas."""
        self.world.reset()
        self.canvas.fill(background)

    def step(self) -> List[Reading]:
        """Advance the world by one step; return a Reading for each turtle in alphabetical order."""
        canvas = self.canvas
        readings = []
        for turtle, teleports, wall, stroke in self.world.step():
            for teleport in teleports:
                canvas.draw(teleport)
            readings.append(Reading(turtle, canvas.color_at(turtle.x, turtle.y_down), wall))
            if stroke is not None:
                canvas.draw(stroke)
        return readings
