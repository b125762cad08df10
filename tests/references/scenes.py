"""The scenes of which Mitsuba 3 made references: each as ours, and the same in Mitsuba's words beside it."""

from tests.references.media import MEDIA
from tests.references.phases import PHASES
from tests.references.surfaces import SURFACES

CASES = [*MEDIA, *SURFACES, *PHASES]
