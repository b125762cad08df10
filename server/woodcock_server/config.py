"""Settings, from environment variables with the prefix WOODCOCK_."""

from __future__ import annotations

from ipaddress import IPv4Network, IPv6Network, ip_network
from pathlib import Path
from typing import Annotated, Any, Literal

from distributed.system import MEMORY_LIMIT
from platformdirs import user_data_path
from pydantic import BeforeValidator, ByteSize, Field
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from woodcock.device import cache_folder


def _networks(given: Any) -> Any:
    return [ip_network(one.strip()) for one in given.split(",") if one.strip()] if isinstance(given, str) else given


class Settings(BaseSettings):
    """Every setting of the service; server/README.md says the same in a table."""

    model_config = SettingsConfigDict(env_prefix="WOODCOCK_", frozen=True)

    data: Path = Field(
        default_factory=lambda: user_data_path("woodcock"),
        description="Folder of everything the service keeps: database, volumes, renders.",
    )
    host: str = Field(default="127.0.0.1", description="Address to listen on.")
    port: Annotated[int, Field(ge=0, le=65535)] = Field(default=8000, description="Port to listen on; 0 takes any.")
    names: Annotated[str, Field(pattern=r"^[^\s/@]*$")] = Field(
        default="",
        description="Host names by which the service may be asked, with commas; by default those of the loopback where "
        "it listens there, else any.",
    )
    insecure: bool = Field(default=False, description="Ask nobody for a token, wherever the service listens.")
    request_rate: Annotated[float, Field(gt=0)] = Field(
        default=100.0, description="Requests a second that one address may make; ten seconds' worth at once."
    )
    log_format: Literal["console", "json"] = Field(
        default="console", description="Logs for people, or a JSON object a line for what collects them."
    )
    upload_limit: ByteSize = Field(default=ByteSize(4 << 30), description="Largest upload accepted, e.g. `4GiB`.")
    parse_memory: Annotated[ByteSize, Field(ge=1 << 28)] = Field(
        default=ByteSize(4 << 30), description="Memory that reading one uploaded file may take."
    )
    parse_seconds: Annotated[int, Field(ge=1)] = Field(
        default=60, description="Time that reading one uploaded file may take."
    )
    database_url: str | None = Field(
        default=None, description="SQLAlchemy URL of the database; by default `woodcock.sqlite` in the data folder."
    )
    store: Annotated[str, Field(pattern=r"^s3://[^/?#]+(/[^?#]*)?$")] | None = Field(
        default=None,
        description="Bucket that uploads and renders are kept in, `s3://bucket/prefix`; by default the data folder. "
        "Credentials, region and endpoint are the environment's (AWS_ACCESS_KEY_ID, AWS_ENDPOINT_URL, …).",
    )
    copies_size: ByteSize = Field(
        default=ByteSize(10 << 30), description="Most that copies of what is in the bucket take, e.g. `100GiB`."
    )
    lease_seconds: Annotated[float, Field(ge=0.5)] = Field(
        default=10.0, description="How long a job stays with a server that no longer answers."
    )
    keep_days: Annotated[float, Field(gt=0)] | None = Field(
        default=None, description="Days after their end at which renders are deleted that nobody pinned."
    )
    keep_size: ByteSize | None = Field(
        default=None, description="Most that renders and uploads take, e.g. `500GiB`; the oldest renders go first."
    )
    owner_jobs: Annotated[int, Field(ge=1)] = Field(
        default=10_000, description="Most jobs of one owner that have not ended."
    )
    owner_paths: Annotated[int, Field(ge=1)] | None = Field(
        default=None, description="Most samples × pixels of one owner's jobs that have not ended."
    )
    owner_storage: ByteSize | None = Field(
        default=None, description="Most that one owner's uploads and renders may take, e.g. `100GiB`."
    )
    range_seconds: Annotated[float, Field(gt=0)] = Field(
        default=1800.0,
        description="Longest that a device may take for one range of samples, or to build a program, before it is "
        "killed; ranges are made to take about one second.",
    )
    scheduler: Annotated[str, Field(pattern=r"^tls://[^\s/]+:\d+$")] | None = Field(
        default=None, description="Address of a farm's scheduler, `tls://HOST:PORT`; by default this machine renders."
    )
    certificates: Path | None = Field(
        default=None,
        description="Folder of ca.crt, tls.crt and tls.key, by which the machines of a farm know each other.",
    )
    worker_name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,47}$")] | None = Field(
        default=None, description="Of a worker's machine, and of no other in the farm; by default the host's name."
    )
    files_port: Annotated[int, Field(ge=0, le=65535)] = Field(
        default=0, description="Port at which the workers of a farm fetch uploaded files; 0 takes any."
    )
    cache: Path = Field(
        default_factory=lambda: cache_folder() / "files", description="Where a worker of a farm keeps uploaded files."
    )
    cache_size: Annotated[ByteSize, Field(gt=0)] = Field(
        default=ByteSize(32 << 30), description="Most that these files may take, e.g. `500GiB`."
    )
    worker_memory: Annotated[ByteSize, Field(gt=0)] = Field(
        default=ByteSize(MEMORY_LIMIT * 9 // 10),
        description="Most memory that a worker process may take before it is killed, e.g. `32GiB`.",
    )
    prepare: bool = Field(
        default=True,
        description="Build the generic program at the start, which renders scenes whose own is still being built.",
    )
    webhook_networks: Annotated[tuple[IPv4Network | IPv6Network, ...], NoDecode, BeforeValidator(_networks)] = Field(
        default=(), description="Internal networks that webhooks may reach, such as `10.1.0.0/16,fd00::/8`."
    )

    @property
    def database(self) -> str:
        """SQLAlchemy URL of the database in use."""
        return self.database_url or f"sqlite:///{(self.data / 'woodcock.sqlite').resolve()}"
