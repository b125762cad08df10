"""Files that scenes name: the service gets each once, and scenes then name it by what comes back."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pydantic import JsonValue

from woodcock.scene import Scene, SceneError, files, with_files
from woodcock_client.connection import Connection, ServiceError
from woodcock_client.models import Volume


class Uploads(Connection):
    """Of Client what concerns files."""

    def upload(self, path: Path) -> Volume:
        """Give the service a volume, mesh or picture; only its digest travels when the service already has it.

        Raises OSError if the file cannot be read.
        """
        with path.open("rb") as file:
            id = f"sha256:{hashlib.file_digest(file, 'sha256').hexdigest()}"
            try:
                return self.volume(id)
            except ServiceError as error:
                if error.status != HTTPStatus.NOT_FOUND:
                    raise
            size = file.tell()
            file.seek(0)
            response = self._request(
                "POST",
                "/api/v1/volumes",
                params={"name": path.name},
                content=file,
                headers={"Content-Type": "application/octet-stream", "Content-Length": str(size)},
            )
        volume = self._read(Volume, response)
        if volume.id != id:
            raise ServiceError(response.status_code, f"{path} changed while it was uploaded; submit it again")
        return volume

    def volume(self, id: str) -> Volume:
        """An uploaded file; `id` is "sha256:" and the digest."""
        return self._read(Volume, self._request("GET", f"/api/v1/volumes/{quote(id, safe=':')}"))

    def _sent(self, scene: Scene) -> dict[str, Any]:
        """The scene with its files uploaded."""
        uploaded = {file: self._upload_for(file) for file in files(scene) if not file.startswith("sha256:")}
        return with_files(scene, lambda file: uploaded.get(file, file)).model_dump(mode="json")

    def _sent_values(self, axes: Mapping[str, Sequence[JsonValue]]) -> dict[str, JsonValue]:
        """The values with their files uploaded."""
        return {path: [self._sent_value(path, value) for value in values] for path, values in axes.items()}

    def _sent_value(self, path: str, value: JsonValue) -> JsonValue:
        if isinstance(value, dict):
            return {key: self._sent_value(key, item) for key, item in value.items()}
        if isinstance(value, list):
            return [self._sent_value("", item) for item in value]
        if path.rpartition(".")[2] == "file" and isinstance(value, str) and not value.startswith("sha256:"):
            return self._upload_for(value)
        return value

    def _upload_for(self, file: str) -> str:
        try:
            return self.upload(Path(file)).id
        except OSError as error:
            raise SceneError(f"{file}: {error.strerror or error}") from None
