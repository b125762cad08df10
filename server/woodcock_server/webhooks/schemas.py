"""Webhooks as the API shows them."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, HttpUrl, SecretStr, field_serializer

from woodcock_server.webhooks.signature import key


def _without_user(url: HttpUrl) -> HttpUrl:
    if url.username is not None or url.password is not None:
        raise ValueError("must not hold a user name or a password; the signature says who sends")
    return url


def _key(secret: SecretStr) -> SecretStr:
    key(secret.get_secret_value())
    return secret


class Webhook(BaseModel):
    """Who is to be told of the job's end, by a POST after standardwebhooks.com.

    url: http or https; redirects are not followed. secret: by which it is signed: `whsec_` and base64 of 24 to 64
    random bytes; no answer shows it.
    """

    model_config = ConfigDict(extra="forbid")

    url: Annotated[HttpUrl, AfterValidator(_without_user)]
    secret: Annotated[SecretStr, AfterValidator(_key)]

    @field_serializer("secret")
    def _kept(self, secret: SecretStr) -> str:
        """For the database, and for telling requests apart."""
        return secret.get_secret_value()


class DeliveryState(StrEnum):
    WAITING = "waiting"  # for the job's end, or for the next attempt
    DELIVERED = "delivered"
    GIVEN_UP = "given up"


class Delivery(BaseModel):
    """How it stands with telling a job's end. error: why the newest attempt failed."""

    url: str
    state: DeliveryState
    attempts: int
    error: str | None
