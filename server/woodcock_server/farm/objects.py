"""Objects of a store, read by URLs that were signed for them."""

from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus
from http.client import HTTPException
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

#: Bytes that are read at a time.
CHUNK = 1 << 20
#: How long the store may say nothing, seconds.
SILENCE = 10.0
#: What a store answers that is asked too much, or not well for a moment.
BUSY = (429, 500, 502, 503, 504)


class Unread(Exception):  # noqa: N818 - it says what happened
    """Bytes did not come; the text says why, and nothing of the URL: whoever has that can read the object.

    again: whether they may come when the store is asked again.
    """

    def __init__(self, says: str, *, again: bool) -> None:
        super().__init__(says)
        self.again = again


def read(url: str, start: int, stop: int) -> Iterator[bytes]:
    """Bytes of an object from start to stop, in order. Raises Unread."""
    try:
        with urlopen(Request(url, headers={"Range": f"bytes={start}-{stop - 1}"}), timeout=SILENCE) as answer:
            if answer.status != HTTPStatus.PARTIAL_CONTENT:
                raise Unread(f"it answered {answer.status}", again=False)
            while start < stop:
                chunk = answer.read(CHUNK)
                if not chunk:
                    raise Unread("the connection broke", again=True)
                start += len(chunk)
                yield chunk
    except HTTPError as error:
        raise Unread(f"it answered {error.code}", again=error.code in BUSY) from None
    except URLError as error:  # No connection could be made.
        raise Unread(str(error.reason), again=False) from None
    except (OSError, HTTPException, ValueError) as error:
        raise Unread(type(error).__name__, again=True) from None
