"""The cases, a file a subject."""

from woodcock.stability.cases import albedo, contrast, depth, emission, limits, phase, picture, rays, scale, size, view

SUBJECTS = (scale, depth, albedo, phase, size, view, contrast, emission, rays, picture, limits)
CASES = tuple(case for subject in SUBJECTS for case in subject.CASES)
