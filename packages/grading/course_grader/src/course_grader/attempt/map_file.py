"""Grades a map file that is handed in, as map_saver writes it: no program runs, and only the student's files are read.

The image is the file of that name beside the YAML file, wherever the map was saved.
"""
import os

from course_grader.isolation import student_files
from course_grader.isolation.limits import MEGABYTE
from course_grader.rules import random_stimuli, scoring, symptoms
from course_grader.rules.observation import Observed, Problem, Sample
from course_grader.supervision.job import Attempted
from kinematic_core.worlds import world_format
from navigation_core.maps import map_files
from navigation_core.maps.map_files import MapError

MAX_IMAGE = 100 * MEGABYTE  # [bytes]


def grade(job):
    """Return the Attempted of a Job whose command is the YAML file of a map."""
    observed = Observed(plan=world_format.parse(job.exercise.world))
    observed.track.append(Sample(0.0, **random_stimuli.start(job.exercise, job.seed)))
    try:
        observed.map = read(os.path.join(job.folder, job.command[0]))
    except MapError as error:
        observed.problem = Problem(str(error))
    return Attempted(symptoms.advise(job.exercise, observed, scoring.decide(job.exercise, observed)), observed)


def read(path):
    """Return the map of a student's file; raise MapError."""
    _check(path)
    described = map_files.read_description(path)
    image = os.path.join(os.path.dirname(path), os.path.basename(described.image))
    _check(image)
    if os.path.exists(image) and not map_files.image_size(student_files.read(image, map_files.HEADER_BYTES)):
        raise MapError(f'{image} is not an image of a map: it must be a PGM or PNG file')
    return map_files.read_image(described._replace(image=image))


def _check(path):
    """Raise MapError for what is not a file of the student's own, or is too large; a missing one is found later."""
    if os.path.islink(path):
        raise MapError(f'{path} is a link: hand in the file itself')
    if os.path.exists(path) and not os.path.isfile(path):
        raise MapError(f'{path} is not a file')
    if os.path.exists(path) and os.path.getsize(path) > MAX_IMAGE:
        raise MapError(f'{path} has {os.path.getsize(path) / MEGABYTE:.0f} MB; at most {MAX_IMAGE / MEGABYTE:g} MB are '
                       'read')
