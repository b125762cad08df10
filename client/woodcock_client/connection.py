"""A connection to the service: requests, streams, and what its refusals say."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx2
from pydantic import BaseModel, ValidationError

from woodcock_client.models import FieldError, Problem

Model = TypeVar("Model", bound=BaseModel)


class Unreachable(RuntimeError):  # noqa: N818 - the name says what happened
    """No answer from the service; the text names its address and what went wrong."""


class ServiceError(RuntimeError):
    """The service refused or failed; the text is its explanation, then one line for each field at fault it left out."""

    def __init__(self, status: int, detail: str, errors: tuple[FieldError, ...] = ()) -> None:
        unsaid = (error for error in errors if error.message not in detail)
        super().__init__("\n".join([detail, *(f"{error.field}: {error.message}" for error in unsaid)]))
        self.status = status
        self.detail = detail
        self.errors = errors


class Connection:
    """What Client asks the service by, and whose errors it raises; the arguments are Client's."""

    def __init__(self, base_url: str, *, timeout: float = 30.0, token: str | None = None) -> None:
        try:
            url = httpx2.URL(base_url)
        except httpx2.InvalidURL:
            url = httpx2.URL()
        if url.scheme not in ("http", "https") or not url.host:
            raise ValueError(f"the service's address must look like http://127.0.0.1:8000 (got {base_url!r})")
        self.base_url = base_url.rstrip("/")
        self._timeout = timeout
        headers = {"Authorization": f"Bearer {token}"} if token else None
        self._http = httpx2.Client(base_url=self.base_url, timeout=timeout, headers=headers)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        self._http.close()

    def _request(self, method: str, path: str, **options: Any) -> httpx2.Response:
        with self._reaching():
            response = self._http.request(method, path, **options)
        if not response.is_success:
            raise self._refusal(response)
        return response

    @contextmanager
    def _stream(self, path: str, *, silence: float | None = None) -> Iterator[httpx2.Response]:
        timeout = httpx2.Timeout(self._timeout, read=silence or self._timeout)
        with self._reaching(), self._http.stream("GET", path, timeout=timeout) as response:
            if not response.is_success:
                response.read()
                raise self._refusal(response)
            yield response

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        try:
            yield
        except httpx2.RequestError as error:
            reason = str(error) or type(error).__name__
            raise Unreachable(f"no answer from the service at {self.base_url}: {reason}") from None

    def _refusal(self, response: httpx2.Response) -> ServiceError:
        """The problem that an answer describes; a proxy's page or an empty body is described by its status."""
        try:
            problem = Problem.model_validate_json(response.content)
        except ValidationError:
            problem = Problem()
        said = problem.detail or problem.title
        bare = f"{self.base_url} answered {response.status_code} {response.reason_phrase}".rstrip()
        return ServiceError(response.status_code, said or bare, problem.errors or ())

    def _read(self, model: type[Model], response: httpx2.Response) -> Model:
        return self._parse(model, response.content, response.status_code)

    def _parse(self, model: type[Model], text: str | bytes, status: int = HTTPStatus.OK) -> Model:
        try:
            return model.model_validate_json(text)
        except ValidationError:
            raise ServiceError(
                status,
                f"{self.base_url} did not answer as a Woodcock service of this client's version would; "
                "check the address and the versions",
            ) from None
