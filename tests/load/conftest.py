"""What the tests of the service have, too."""

from tests.server.conftest import make_scene as make_scene
from tests.server.conftest import postgres as postgres
