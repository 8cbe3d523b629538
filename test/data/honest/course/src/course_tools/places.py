"""A module of a student's own package."""


def pose(values):
    return float(values['x']), float(values['y']), float(values.get('theta', 0.0))
