"""Packed streams, unpacked only as far as a header says: no more memory than that, whatever the stream would give."""

from __future__ import annotations

import bz2
import zlib

from woodcock.formats.grid import Data, VolumeError, check_bytes

_CHUNK = 1 << 16  # of which the rest is copied for each member that begins in it
_DEFLATE_RATIO = 1032  # no deflate stream unpacks to more than this many times its size
_WINDOW = {"gzip": 31, "zlib": 15, "deflate": -15}  # how zlib is told the wrapping


def check_packed(packed: int, size: int, kind: str) -> None:
    """Refuses a stream of `packed` bytes that cannot unpack to `size`, or to what memory does not hold."""
    if kind in _WINDOW and size > packed * _DEFLATE_RATIO:
        raise VolumeError(f"is cut short: {packed} packed bytes cannot hold {size}")
    check_bytes(size, "unpacks to")


def unpack(data: Data, start: int, end: int, size: int, kind: str) -> bytearray:
    """The first `size` bytes of what [start, end) unpacks to; `kind` is `gzip`, `zlib`, `deflate` or `bzip2`. Of gzip
    and bzip2 several members may follow each other. Raises VolumeError if the stream is damaged or gives less, or as
    `check_packed` does."""
    check_packed(end - start, size, kind)
    try:
        unpacked = _unpack(data, start, end, size, kind)
    except (zlib.error, OSError, EOFError):
        raise VolumeError(f"is damaged: its {kind} stream cannot be unpacked") from None
    if len(unpacked) < size:
        raise VolumeError(f"is cut short: its {kind} stream holds {len(unpacked)} bytes where {size} are due")
    return unpacked


def _unpack(data: Data, start: int, end: int, size: int, kind: str) -> bytearray:
    unpacked, packed, stream = bytearray(), b"", _Stream(kind)
    while True:
        if not packed and stream.needs_input:
            packed = data[start : min(start + _CHUNK, end)]
            start += len(packed)
            if not packed and len(unpacked) == size:
                raise EOFError  # all is there but the end of the stream, and so its checksum
            if not packed:
                return unpacked
        # One byte more than is due, so that the checksum behind the last is met if it stands there.
        piece, packed = stream.unpack(packed, size - len(unpacked) + 1)
        unpacked += piece
        if len(unpacked) > size:
            del unpacked[size:]
            return unpacked
        if stream.eof:
            if kind in ("zlib", "deflate") or len(unpacked) == size:
                return unpacked
            stream = _Stream(kind)


class _Stream:
    """One member, by zlib or bz2, which hand back what they did not take in two different ways."""

    def __init__(self, kind: str) -> None:
        self._bzip2 = bz2.BZ2Decompressor() if kind == "bzip2" else None
        self._zlib = zlib.decompressobj(_WINDOW.get(kind, 15))

    @property
    def needs_input(self) -> bool:
        return self._bzip2.needs_input if self._bzip2 else True

    @property
    def eof(self) -> bool:
        return self._bzip2.eof if self._bzip2 else self._zlib.eof

    def unpack(self, packed: bytes, most: int) -> tuple[bytes, bytes]:
        """At most `most` bytes, and what is left of `packed`."""
        if self._bzip2:
            return self._bzip2.decompress(packed, most), self._bzip2.unused_data
        return self._zlib.decompress(packed, most), self._zlib.unused_data or self._zlib.unconsumed_tail
