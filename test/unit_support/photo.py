"""Render photos of printed squares as a camera takes them: bent and creased sheets, shadows, glare, blur, noise, JPEG.

A ray through every fine pixel is cut with the sheet, which may be a plane, a cylinder or two planes, so corners and
perspective are exact. The light is a function of the pixel. Frames: the sheet's is that of a marker (alvar_core.
drawing) and touches a bent sheet in its middle; sheet coordinates s (right) and t (up) [m] are measured on the paper.
"""
from dataclasses import dataclass, field
from typing import Any, Callable, List, Optional, Tuple

import cv2
import numpy as np

from alvar_core import drawing
from alvar_core.camera import Camera

FINE = 4  # fine pixels in a pixel, along each axis
SPARE = 10  # px around a sheet that are rendered finely
DENSE = 3  # px around a sheet that belong to it, if others are near
AMBIENT = 0.4  # share of the light that comes from all sides

Light = Callable[[Any, Any], Any]  # of the real pixels x, y: times the light of an evenly lit sheet


class Flat:
    """A flat sheet."""

    def to_space(self, s, t):
        """Return the places (..., 3) [m] of sheet coordinates."""
        return np.stack([s, t, np.zeros_like(s)], -1)

    def to_sheet(self, origin, rays):
        """Return, for each side of the surface that a ray (..., 3) may meet: s, t, shading, whether it is met."""
        with np.errstate(divide='ignore', invalid='ignore'):
            k = -origin[2] / rays[..., 2]
        return [(origin[0] + k * rays[..., 0], origin[1] + k * rays[..., 1], 1.0, k > 0)]


@dataclass
class Cylinder(Flat):
    """A sheet bent about an axis at ``angle`` [rad] to the upper side; ``radius`` [m], negative: a hollow."""

    radius: float
    angle: float

    def _across(self):
        return np.array([np.cos(self.angle), np.sin(self.angle)]), np.array([-np.sin(self.angle), np.cos(self.angle)])

    def to_space(self, s, t):
        across, along = self._across()
        arc, v = s * across[0] + t * across[1], s * along[0] + t * along[1]
        u, z = self.radius * np.sin(arc / self.radius), -self.radius * (1 - np.cos(arc / self.radius))
        return np.stack([u * across[0] + v * along[0], u * across[1] + v * along[1], z], -1)

    def to_sheet(self, origin, rays):
        across, along = self._across()
        ou, oz = origin[:2] @ across, origin[2] + self.radius
        du, dz = rays[..., :2] @ across, rays[..., 2]
        a, b, c = du * du + dz * dz, ou * du + oz * dz, ou * ou + oz * oz - self.radius ** 2
        root = b * b - a * c
        out = []
        for sign in (-1, 1):
            k = (-b + sign * np.sqrt(np.maximum(root, 0))) / a
            turn = np.arctan2((ou + k * du) / self.radius, (oz + k * dz) / self.radius)
            v = origin[:2] @ along + k * (rays[..., :2] @ along)
            arc = self.radius * turn
            shade = AMBIENT + (1 - AMBIENT) * np.maximum(np.cos(turn - 0.4) / np.cos(0.4), 0)
            out.append((arc * across[0] + v * along[0], arc * across[1] + v * along[1], shade, (root > 0) & (k > 0)))
        return out


@dataclass
class Creased(Flat):
    """A sheet folded by ``fold`` [rad] along a line at ``angle`` [rad], ``offset`` [m] above 0 from its middle."""

    fold: float
    angle: float
    offset: float

    def to_space(self, s, t):
        c, n = np.cos(self.angle), np.sin(self.angle)
        u, v = s * c + t * n, -s * n + t * c
        beyond = np.maximum(u - self.offset, 0)
        u, z = np.minimum(u, self.offset) + beyond * np.cos(self.fold), -beyond * np.sin(self.fold)
        return np.stack([u * c - v * n, u * n + v * c, z], -1)

    def to_sheet(self, origin, rays):
        c, n = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[c, n, 0], [-n, c, 0], [0, 0, 1]])
        origin, rays = turn @ origin, rays @ turn.T
        with np.errstate(divide='ignore', invalid='ignore'):
            k = -origin[2] / rays[..., 2]
            u, v = origin[0] + k * rays[..., 0], origin[1] + k * rays[..., 1]
            flat = u * c - v * n, u * n + v * c, 1.0, (k > 0) & (u <= self.offset)
            normal = np.array([np.sin(self.fold), 0, np.cos(self.fold)])
            k = (np.array([self.offset, 0, 0]) - origin) @ normal / (rays @ normal)
            x, v, z = (origin[i] + k * rays[..., i] for i in range(3))
        w = (x - self.offset) * np.cos(self.fold) - z * np.sin(self.fold)
        u = self.offset + w
        shade = AMBIENT + (1 - AMBIENT) * np.cos(self.fold - 0.4) / np.cos(0.4)
        return [flat, (u * c - v * n, u * n + v * c, shade, (k > 0) & (w > 0))]


@dataclass
class Sheet:
    """A printed square on white paper.

    ``white`` (n, n) bool: the cells of the square with its border; ``id``: None unless it is one of our markers;
    ``size`` [m]: width of the square; ``rotation`` (3, 3), ``position`` (3,) [m]: pose of the plane that touches the
    middle; ``paper``: white margin as a share of the size; ``greys``: of print and paper.
    """

    white: Any
    id: Optional[int]
    size: float
    rotation: Any
    position: Any
    surface: Flat = field(default_factory=Flat)
    paper: float = 0.15
    greys: Tuple[float, float] = (25.0, 200.0)

    def project(self, camera, s, t):
        """Return the real pixels (N, 2) of sheet coordinates, in units of the size."""
        points = self.surface.to_space(np.asarray(s, float) * self.size, np.asarray(t, float) * self.size)
        return drawing.project(camera, self.rotation, self.position, points)

    def corners(self, camera):
        """Return the corners (4, 2) [real px] of the square, in the order of a Detection."""
        return self.project(camera, drawing.UNIT_CORNERS[:, 0], drawing.UNIT_CORNERS[:, 1])

    def outline(self, camera):
        """Return points (N, 2) [real px] along the edge of the paper."""
        line, half = np.linspace(-1, 1, 9), 0.5 + self.paper
        s = np.concatenate([line, np.ones(9), line, -np.ones(9)]) * half
        t = np.concatenate([np.ones(9), line, -np.ones(9), line]) * half
        return self.project(camera, s, t)


@dataclass
class Photo:
    """A scene, and how it is photographed.

    ``lights``: multiply the light; ``glare``: grey that is added, a function as a Light; ``covers``: dark or light
    discs (x, y, radius [px], grey); ``blur`` [px]: standard deviation; ``motion`` (2,) [px]: of the camera while the
    shutter is open; ``noise`` [greys]; ``gain``: exposure; ``jpeg``: quality, or None; ``dense``: sheets are so near to
    each other that the surroundings of one must not hide the next.
    """

    camera: Camera
    size: Tuple[int, int]
    sheets: List[Sheet]
    lights: List[Light] = field(default_factory=list)
    glare: Optional[Light] = None
    covers: List[Tuple[float, float, float, float]] = field(default_factory=list)
    blur: float = 0.6
    motion: Tuple[float, float] = (0.0, 0.0)
    noise: float = 2.0
    gain: float = 1.0
    jpeg: Optional[int] = None
    table: Optional[float] = None
    clutter: int = 12
    dense: bool = False

    def render(self, rng):
        """Return the grey image (height, width), uint8."""
        width, height = self.size
        back = self._background(rng)
        everywhere = slice(0, height), slice(0, width)
        image = self._blurred(self._lit(back, everywhere, 1), 1)
        for sheet in self.sheets:
            window = self._window(sheet)
            rows, columns = window
            high, wide = rows.stop - rows.start, columns.stop - columns.start
            if high < 3 or wide < 3:
                continue
            fine = cv2.resize(np.ascontiguousarray(back[window]), (wide * FINE, high * FINE))
            done = self._print(fine, sheet, window)
            fine = cv2.resize(self._blurred(self._lit(fine, window, FINE), FINE), (wide, high),
                              interpolation=cv2.INTER_AREA)
            if self.dense:
                near = cv2.blur(done.astype(np.float32), (2 * FINE * DENSE + 1, 2 * FINE * DENSE + 1))
                fine = np.where(cv2.resize(near, (wide, high), interpolation=cv2.INTER_AREA) > 0, fine, image[window])
            image[window] = fine
        noise = np.sqrt(self.noise ** 2 * (0.3 + 0.7 * np.clip(image, 0, 255) / 128))  # of reading, and of the light
        image = np.clip(np.round(image + rng.normal(0, 1, image.shape) * noise), 0, 255).astype(np.uint8)
        if self.jpeg is not None:
            image = cv2.imdecode(cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg])[1], 0)
        return image

    def _background(self, rng):
        width, height = self.size
        grey = rng.uniform(60, 150) if self.table is None else self.table
        rough = grey + rng.normal(0, 0.15 * grey, (height // 60 + 2, width // 60 + 2)).astype(np.float32)
        back = cv2.resize(rough.astype(np.float32), self.size, interpolation=cv2.INTER_CUBIC)
        for _ in range(self.clutter):
            x, y = rng.uniform([0, 0], [width, height]).tolist()
            a, b, turn = rng.uniform(10, 120), rng.uniform(3, 60), rng.uniform(0, 180)
            box = cv2.boxPoints(((x, y), (a, b), turn)).astype(np.int32)
            cv2.fillPoly(back, [box], float(rng.uniform(15, 230)), cv2.LINE_AA)
        return back

    def _window(self, sheet):
        width, height = self.size
        points = sheet.outline(self.camera)
        spare = SPARE + int(3 * self.blur + np.abs(self.motion).max())
        left, top = np.clip(np.floor(points.min(0)) - spare, 0, [width, height]).astype(int).tolist()
        right, bottom = np.clip(np.ceil(points.max(0)) + spare, 0, [width, height]).astype(int).tolist()
        return slice(top, bottom), slice(left, right)

    def _print(self, fine, sheet, window):
        rows, columns = window
        y, x = np.mgrid[rows.start - 1:rows.stop + 1, columns.start - 1:columns.stop + 1].astype(np.float64)
        ideal = self.camera.to_rays(self.camera.to_ideal(np.stack([x, y], -1))).astype(np.float32)
        high, wide = ideal.shape[:2]
        ideal = cv2.resize(ideal, (wide * FINE, high * FINE))[FINE:-FINE, FINE:-FINE].astype(np.float64)
        rays = np.concatenate([ideal, np.ones(ideal.shape[:2] + (1,))], -1) @ sheet.rotation
        origin = -sheet.rotation.T @ sheet.position
        done = np.zeros(fine.shape, bool)
        count = len(sheet.white)
        padded = np.pad(sheet.white, 8, constant_values=True)
        low, high = sheet.greys
        for s, t, shade, met in sheet.surface.to_sheet(origin, rays):
            s, t = s / sheet.size, t / sheet.size
            on = met & ~done & (np.maximum(np.abs(s), np.abs(t)) < 0.5 + sheet.paper)
            column, row = (np.clip(np.floor((v[on] + 0.5) * count) + 8, 0, count + 15).astype(int) for v in (s, -t))
            grey = np.where(padded[row, column], high, low)
            fine[on] = grey * (shade[on] if np.ndim(shade) else shade)
            done |= on
        return done

    def _lit(self, grey, window, fine):
        rows, columns = window
        y, x = ((np.arange(part.start * fine, part.stop * fine, dtype=np.float32) + 0.5) / fine - 0.5
                for part in (rows, columns))
        y = y[:, None]
        lit = grey * self.gain
        for light in self.lights:
            lit = lit * light(x, y)
        if self.glare is not None:
            lit = lit + self.glare(x, y)
        lit = lit.astype(np.float32)
        for cx, cy, radius, disc in self.covers:
            lit[(x - cx) ** 2 + (y - cy) ** 2 < radius ** 2] = disc
        return lit

    def _blurred(self, grey, fine):
        if np.hypot(*self.motion) > 0:
            reach = int(np.ceil(np.abs(self.motion).max() * fine)) + 1
            kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
            for k in np.linspace(-0.5, 0.5, 8 * reach + 1):
                column, row = (int(round(reach + k * move * fine)) for move in self.motion)
                kernel[row, column] += 1
            grey = cv2.filter2D(grey, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)
        return cv2.GaussianBlur(grey, (0, 0), self.blur * fine, borderType=cv2.BORDER_REPLICATE)


def with_gamma(image, gamma):
    """Return a rendered image as a camera whose response is light ** (1 / gamma) shows it; 1: light itself."""
    greys = np.round(255 * (np.arange(256) / 255) ** (1 / gamma)).astype(np.uint8)
    return cv2.LUT(image, greys)


def shadow(at, angle, width, left):
    """Return the Light of a shadow's edge through a pixel ``at``, at ``angle`` [rad].

    ``width`` [px]: of the half-shadow; ``left``: share of the light that is left in the shadow.
    """
    def light(x, y):
        across = (x - at[0]) * np.cos(angle) + (y - at[1]) * np.sin(angle)
        return left + (1 - left) * _step(across / width)
    return light


def stripes(at, angle, period, share, width, left):
    """Return the Light of dark stripes; ``period``, ``width`` of the half-shadow [px]; ``share``: how much is dark."""
    def light(x, y):
        across = (x - at[0]) * np.cos(angle) + (y - at[1]) * np.sin(angle)
        middle = np.abs(across - period * np.round(across / period))
        return left + (1 - left) * _step((middle - share * period / 2) / width)
    return light


def band(at, angle, across_px, width, left):
    """Return the Light of a single dark band, ``across_px`` [px] wide."""
    def light(x, y):
        middle = np.abs((x - at[0]) * np.cos(angle) + (y - at[1]) * np.sin(angle))
        return left + (1 - left) * _step((middle - across_px / 2) / width)
    return light


def gradient(at, angle, reach, left):
    """Return the Light that falls from 1 to ``left`` over ``reach`` [px] around a pixel ``at``."""
    def light(x, y):
        across = ((x - at[0]) * np.cos(angle) + (y - at[1]) * np.sin(angle)) / reach
        return left + (1 - left) * np.clip(across + 0.5, -0.3, 1.3)
    return light


def spot(at, radius, grey):
    """Return the glare of a lamp: ``grey`` [greys] in its middle, ``radius`` [px] its standard deviation."""
    def glare(x, y):
        return grey * np.exp(-0.5 * ((x - at[0]) ** 2 + (y - at[1]) ** 2) / radius ** 2)
    return glare


def _step(x):
    x = np.clip(x + 0.5, 0, 1)
    return x * x * (3 - 2 * x)
