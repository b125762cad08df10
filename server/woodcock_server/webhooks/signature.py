"""Signatures of webhooks, after the Standard Webhooks specification 1.0.0 (standardwebhooks.com), symmetric."""

from __future__ import annotations

import base64
import binascii
import hmac

PREFIX = "whsec_"
#: Bytes that a secret may have.
SHORTEST, LONGEST = 24, 64


def key(secret: str) -> bytes:
    """The bytes that a secret stands for. Raises ValueError, with a text that does not tell it."""
    try:
        found = base64.b64decode(secret.removeprefix(PREFIX), validate=True)
    except (binascii.Error, ValueError):
        found = b""
    if not (secret.startswith(PREFIX) and SHORTEST <= len(found) <= LONGEST):
        raise ValueError(f"must be {PREFIX} and base64 of {SHORTEST} to {LONGEST} random bytes")
    return found


def headers(id: str, timestamp: int, body: bytes, secret: str) -> dict[str, str]:
    """What proves a message. id: the same for every attempt; timestamp: of this one, Unix seconds."""
    digest = hmac.digest(key(secret), f"{id}.{timestamp}.".encode() + body, "sha256")
    return {
        "webhook-id": id,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }
