"""Names that people give to what the service keeps."""

from __future__ import annotations

import unicodedata

from pydantic import AfterValidator


def _one_line(text: str) -> str:
    if any(unicodedata.category(letter) in ("Cc", "Zl", "Zp") for letter in text):
        raise ValueError("must not have control characters or line breaks")
    return text


#: Of a text that pages, terminals and every database can show.
ONE_LINE = AfterValidator(_one_line)
