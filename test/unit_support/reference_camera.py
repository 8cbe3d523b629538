"""A slow ray tracer to compare the renderer with: each pixel by itself, in space, by slabs and circles."""
import math

import numpy as np

from kinematic_core.worlds.camera import DEPTH_FAR, DEPTH_NEAR, NEAR
from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel
from sim_scene.faces import TOP_SHADE, UNDER_SHADE, shade

SKY, FLOOR = -1, -2


def rays(camera, pose):
    """World directions (height, width, 3) whose part along the optical axis is 1."""
    ahead = np.array([math.cos(pose[3]), math.sin(pose[3]), 0.0])
    right = np.array([math.sin(pose[3]), -math.cos(pose[3]), 0.0])
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return (ahead + ((u - camera.cx) / camera.focal)[..., None] * right
            - ((v - camera.cy) / camera.focal)[..., None] * np.array([0.0, 0.0, 1.0]))


def _slab(origin, direction, low, high):
    with np.errstate(divide='ignore', invalid='ignore'):
        first, second = (low - origin) / direction, (high - origin) / direction
    inside = low < origin < high
    still = np.abs(direction) < 1e-15
    return (np.where(still, -np.inf if inside else np.inf, np.minimum(first, second)),
            np.where(still, np.inf if inside else -np.inf, np.maximum(first, second)))


def _enter_box(box, pose, directions):
    """Depth of entry (inf: missed) and the world normal there."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    middle = np.array([box.x, box.y, box.bottom + box.height / 2])
    half = np.array([box.length, box.width, box.height]) / 2
    origin, direction = axes @ (np.array(pose[:3]) - middle), directions @ axes.T
    enter, leave = zip(*(_slab(origin[k], direction[..., k], -half[k], half[k]) for k in range(3)))
    which = np.argmax(enter, axis=0)
    begin, end = np.max(enter, axis=0), np.min(leave, axis=0)
    normal = -np.sign(np.take_along_axis(direction, which[..., None], -1)) * axes[which]
    return np.where((begin < end) & (begin > NEAR), begin, np.inf), normal


def _enter_cylinder(shape, pose, directions):
    x, y = pose[0] - shape.x, pose[1] - shape.y
    dx, dy = directions[..., 0], directions[..., 1]
    a, b, c = dx * dx + dy * dy, x * dx + y * dy, x * x + y * y - shape.radius ** 2
    with np.errstate(invalid='ignore'):
        root = np.sqrt(b * b - a * c)
    first, last = _slab(pose[2], directions[..., 2], shape.bottom, shape.bottom + shape.height)
    side, beyond = np.nan_to_num((-b - root) / a, nan=np.inf), np.nan_to_num((-b + root) / a, nan=-np.inf)
    begin, end = np.maximum(side, first), np.minimum(beyond, last)
    hit = (begin < end) & (begin > NEAR)
    depth = np.where(hit, begin, 0.0)
    around = np.stack([(x + depth * dx) / shape.radius, (y + depth * dy) / shape.radius, np.zeros_like(depth)], -1)
    upright = (side > first)[..., None]
    return np.where(hit, begin, np.inf), np.where(upright, around, np.sign(-directions[..., 2:]) * [0.0, 0.0, 1.0])


def trace(plan, camera, pose):
    """Return (depth [m], solid or SKY or FLOOR, colour float RGB), each (height, width[, 3]), without patterns."""
    directions = rays(camera, pose)
    down = -directions[..., 2]
    depth = np.where(down > 0.0, pose[2] / np.where(down > 0.0, down, 1.0), np.inf)
    solid = np.where(down >= 0.0, FLOOR, SKY)
    colour = np.where((down >= 0.0)[..., None], plan.ground_colour, plan.sky_colour).astype(float)
    for index, shape in enumerate(plan.solids()):
        enter, normal = (_enter_box if isinstance(shape, Box) else _enter_cylinder)(shape, pose, directions)
        nearer = enter < depth
        depth[nearer], solid[nearer] = enter[nearer], index
        tone = np.where(normal[..., 2] > 0.5, TOP_SHADE,
                        np.where(normal[..., 2] < -0.5, UNDER_SHADE, shade(normal[..., 0], normal[..., 1])))
        colour[nearer] = (tone[..., None] * shape.colour)[nearer]
    return depth, solid, colour


def reported(depth):
    """Depths as the camera reports them: NaN outside its range."""
    return np.where((depth > DEPTH_NEAR) & (depth < DEPTH_FAR), depth, np.nan)


def inner(solid, colour):
    """Mask of pixels that are away from all edges: their eight neighbours show the same face."""
    face = np.round(np.concatenate([solid[..., None] * 1000.0, colour], -1))
    padded = np.pad(face, ((1, 1), (1, 1), (0, 0)), mode='edge')
    height, width = solid.shape
    out = np.ones(solid.shape, bool)
    for row in range(3):
        for column in range(3):
            out &= (np.abs(padded[row:row + height, column:column + width] - face) < 8.0).all(-1)
    return out


def random_plan(rng):
    """Return a FloorPlan with up to 8 boxes, 4 cylinders and 3 panels around the origin."""
    def colour():
        return tuple(int(part) for part in rng.integers(40, 230, 3))
    heights = rng.permutation(24) * 0.05 + 0.05  # none alike: two ends in one plane would both be right
    boxes = [Box(f'box{k}', *rng.uniform(-3, 3, 2), rng.uniform(-4, 4), *rng.uniform(0.05, 2.5, 2), heights[k],
                 rng.choice([0.0, 0.0, 0.0, 0.11 + 0.003 * k]), colour()) for k in range(rng.integers(0, 9))]
    cylinders = [Cylinder(f'cylinder{k}', *rng.uniform(-3, 3, 2), rng.uniform(0.05, 0.7), heights[12 + k],
                          rng.choice([0.0, 0.0, 0.31 + 0.003 * k]), colour()) for k in range(rng.integers(0, 5))]
    panels = [Panel(f'panel{k}', k, *rng.uniform(-3, 3, 2), rng.uniform(-4, 4), bottom=0.05 + 0.001 * k)
              for k in range(rng.integers(0, 4))]
    return FloorPlan(tuple(boxes), tuple(cylinders), tuple(panels))
