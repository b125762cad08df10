"""Objects of a store, read by URLs that were signed for them."""

from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus
from http.client import HTTPException
from urllib.error import HTTPError
from urllib.request import Request, urlopen

#: Bytes that are read at a time.
CHUNK = 1 << 20
#: How long the store may say nothing, seconds.
SILENCE = 10.0


class Unread(Exception):  # noqa: N818 - it says what happened
    """Bytes did not come; the text says why, and nothing of the URL: whoever has that can read the object."""


def read(url: str, start: int, stop: int) -> Iterator[bytes]:
    """Bytes of an object from start to stop, in order. Raises Unread."""
    try:
        with urlopen(Request(url, headers={"Range": f"bytes={start}-{stop - 1}"}), timeout=SILENCE) as answer:
            if answer.status != HTTPStatus.PARTIAL_CONTENT:
                raise Unread(f"it answered {answer.status}")
            while start < stop:
                chunk = answer.read(CHUNK)
                if not chunk:
                    raise Unread("the connection broke")
                start += len(chunk)
                yield chunk
    except HTTPError as error:
        raise Unread(f"it answered {error.code}") from None
    except (OSError, HTTPException, ValueError) as error:
        raise Unread(str(getattr(error, "reason", "")) or type(error).__name__) from None
