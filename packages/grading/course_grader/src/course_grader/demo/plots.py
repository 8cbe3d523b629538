"""Draw a measured value over time."""
import cv2
import numpy as np

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 480, 320, 58, 44, 18, 46  # [px] of the picture; margins around the axes
PAPER, GRID, INK, LINE, GOAL = (250, 252, 252), (232, 230, 228), (52, 44, 40), (196, 96, 22), (40, 32, 176)  # BGR
FONT = cv2.FONT_HERSHEY_SIMPLEX


def over_time(title, times, values, goal, longest, between):
    """Return a plot (HEIGHT, WIDTH, 3) uint8 BGR of distances [m] over times [s], with a line at the goal.

    The axes go to ``longest`` [s] and ``between`` two distances [m], so that two plots can be compared.
    """
    low, high = between
    image = np.full((HEIGHT, WIDTH, 3), PAPER, np.uint8)
    axes = image[TOP - 1:HEIGHT - BOTTOM + 2]  # nothing is drawn above and below

    def pixels(seconds, metres):
        columns = LEFT + np.asarray(seconds, float) * (WIDTH - LEFT - RIGHT) / longest
        rows = HEIGHT - BOTTOM - (np.asarray(metres, float) - low) * (HEIGHT - TOP - BOTTOM) / (high - low)
        return np.stack(np.broadcast_arrays(columns, rows), -1).round().astype(np.int32)

    def line(seconds, metres, colour, width):
        cv2.polylines(axes, [pixels(seconds, metres) - [0, TOP - 1]], False, colour, width, cv2.LINE_AA)

    def text(words, column, row, size=0.5, colour=INK):
        cv2.putText(image, words, (int(column), int(row)), FONT, size, colour, 1, cv2.LINE_AA)
    for second in range(0, int(longest) + 1, 2):
        line([second, second], between, INK if second == 0 else GRID, 1)
        text(f'{second}', pixels(second, low)[0] - 6, HEIGHT - BOTTOM + 20)
    for metre in np.arange(low, high + 0.01, 0.1):
        line([0.0, longest], [metre, metre], INK if metre == low else GRID, 1)
        text(f'{metre:.1f}', 24, pixels(0.0, metre)[1] + 5)
    line([0.0, longest], [goal, goal], GOAL, 1)
    text('goal', WIDTH - RIGHT - 40, pixels(0.0, goal)[1] - 6, colour=GOAL)
    line(times, values, LINE, 2)
    text(title, LEFT, 28, 0.7)
    text('m', 6, TOP + 6)
    text('time [s]', WIDTH - RIGHT - 66, HEIGHT - 8)
    return image
