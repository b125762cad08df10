"""Which piece each device renders next, round by round until the contract is met. Pure: others render and merge."""

from __future__ import annotations

from collections.abc import Sequence

from woodcock.contract import Piece, next_round
from woodcock.film import Film
from woodcock.pace import Pace, fit
from woodcock.scene import Scene, SecondsStop
from woodcock_server.ranges import LONGEST_SECONDS, Pool, length, share, turn_of

#: Pieces that a device has at a time: it renders one while the other waits.
AT_A_TIME = 2


class Rounds:
    """A round ends when all of its pieces are merged: only then does the film tell what the next one should hold.

    over: the contract is met.
    """

    def __init__(
        self, scene: Scene, devices: Sequence[str], film: Film | None, longest: float = LONGEST_SECONDS
    ) -> None:
        """film: of former attempts; longest: seconds that a piece may take."""
        self._stop, self._pixels = scene.stop, scene.film.width * scene.film.height
        self._paces = {device: Pace() for device in devices}
        self._with: dict[str, list[Piece]] = {device: [] for device in devices}
        self._unmerged = 0
        self._longest = longest
        self._merging, self._merges = 0.0, 0  # seconds, and of how many films
        self._begun = self._kept = film is not None
        self.begin(film)

    def begin(self, film: Film | None) -> None:
        """The next round."""
        pieces = next_round(self._stop, film)
        self._pool = Pool(pieces, self._pixels)
        self.over = not pieces

    def join(self, device: str) -> None:
        """A device that came later, or came back."""
        self._paces[device], self._with[device] = Pace(), []

    def leave(self, device: str) -> None:
        """A device is gone: others render the pieces that it has."""
        pieces = self._with.pop(device)
        del self._paces[device]
        self._unmerged -= len(pieces)
        self._pool.put_back(pieces)
        self._begun = self._kept or self._unmerged > 0

    def take(self, device: str, seconds: float) -> Piece | None:
        """The device's next piece; None for none now. seconds: rendering time so far."""
        if not self._pool.left or len(self._with[device]) == AT_A_TIME:
            return None
        if (count := self._count(device, seconds)) == 0:
            return None
        piece = self._pool.take(count)
        self._begun = True
        self._unmerged += 1
        self._with[device].append(piece)
        return piece

    def _count(self, device: str, seconds: float) -> int:
        """Samples of the next piece."""
        pace = self._paces[device]
        turn = turn_of(len(self._paces), self._merging / max(self._merges, 1))
        should = length(turn, self._longest)
        if not isinstance(self._stop, SecondsStop):
            return share(pace, self._pool, sum(other.rate for other in self._paces.values()), should, turn)
        ahead = sum((piece.stop - piece.start) * piece.width(self._pixels) for piece in self._with[device])
        if pace.rate == 0 and ahead:  # One sample tells how long a second would take.
            return 0
        left = self._stop.seconds - seconds - (ahead / pace.rate if ahead else 0.0)
        return fit(pace, left, nothing_yet=not self._begun, pixels=self._pool.pixels, longest=should)

    def rendered(self, device: str, seconds: float) -> None:
        """The first of the pieces that the device has is done; it took so long."""
        piece = self._with[device].pop(0)
        self._paces[device].measured(piece.stop - piece.start, seconds, piece.width(self._pixels))

    def merged(self, seconds: float = 0.0) -> bool:
        """Another piece is in the film; merging took so long. Has the round ended?"""
        self._unmerged -= 1
        self._merging += seconds
        self._merges += 1
        self._kept = True
        return not (self._unmerged or self._pool.left)

    @property
    def timed_out(self) -> bool:
        """Of a device that gets no piece and has none: is this for want of time? Otherwise others render the rest."""
        return self._pool.left > 0
