"""The database's tables, for SQLite and PostgreSQL alike. A change here needs a migration; a test compares the two."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    DateTime,
    Dialect,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
    false,
)


class UtcDateTime(TypeDecorator[datetime]):
    """Aware times in UTC; SQLite keeps none of the zone, so it is put back here."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        return None if value is None else value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
    }
)

jobs = Table(
    "jobs",
    metadata,
    Column("id", String(36), primary_key=True),  # sorts by time of creation
    Column("owner", String(200), nullable=False, server_default=""),  # of the token that asked for it
    Column("name", String(200), nullable=False),
    Column("scene", JSON, nullable=False),
    Column("device", String(64), nullable=False),  # what it asks for: an id, a kind, or any
    Column("reference", String(71)),  # what its picture is held against: a job's id, or that of an uploaded picture
    Column("comparison", String(36)),  # whose variant it renders
    Column("batch", String(36), ForeignKey("batches.id")),  # that it is one of
    Column("point", JSON(none_as_null=True)),  # path -> value: where in the batch's sweep it is
    Column("retry_of", String(36)),  # the job that it does once more
    Column("extends", String(36)),  # the job whose samples it goes on from
    Column("priority", Integer, nullable=False, server_default="0"),  # the higher ones are rendered first
    Column("pinned", Boolean, nullable=False, server_default=false()),  # stays, however old it is
    Column("state", String(16), nullable=False),  # jobs.states.State
    Column("created_at", UtcDateTime, nullable=False),
    Column("started_at", UtcDateTime),
    Column("finished_at", UtcDateTime),
    # How far it is. The truth about samples is the checkpoint's Film, which names the ranges it holds.
    Column("paths", BigInteger, nullable=False, server_default="0"),  # samples × pixels that it asks for; else 0
    Column("samples", BigInteger, nullable=False),
    Column("seconds", Float, nullable=False),
    Column("rmse", Float),
    Column("relative_rmse", Float),
    Column("reached", Float),  # of a relative_error contract, the error that it looks at
    Column("series", JSON, nullable=False),  # list of woodcock.series.Point
    Column("usage", JSON, nullable=False),  # device id -> woodcock.report.Use
    Column("spent", JSON, nullable=False),  # merge, check and write -> wall seconds
    Column("integrator", String(64)),  # that it is rendered by, as its usage says
    # The series and the usage as of the checkpoint before: they are written first, so one of the two fits the Film.
    Column("kept", JSON(none_as_null=True)),
    Column("error", Text),
    Column("size", BigInteger),  # of its files once it has ended, bytes
    # Who renders it. Every write of a dispatcher names the token it claimed the job with.
    Column("token", Integer, nullable=False),
    Column("holder", String(200)),
    Column("lease_until", UtcDateTime),
    Index(None, "state", "priority", "id"),
    # Whole answers: what each owner rendered lately, waits for, keeps.
    Index(None, "owner", "started_at", "seconds"),
    Index(None, "owner", "state", "paths"),
    Index(None, "owner", "size"),
    Index(None, "finished_at", "id"),
    Index(None, "batch", "id"),
    # Pages of what is alike, newest first.
    Index(None, "integrator", "id"),
    Index(None, "state", "id"),
)

#: Words to find jobs by.
job_tags = Table(
    "job_tags",
    metadata,
    Column("job_id", String(36), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("tag", String(64), primary_key=True),
    Index(None, "tag", "job_id"),
)

#: Devices that have rendered a job, as its usage says.
job_devices = Table(
    "job_devices",
    metadata,
    Column("job_id", String(36), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("device", String(64), primary_key=True),
    Index(None, "device", "job_id"),
)

#: Uploaded files that a job needs, which therefore stay.
job_files = Table(
    "job_files",
    metadata,
    Column("job_id", String(36), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("file", String(71), ForeignKey("volumes.id"), primary_key=True),
    Index(None, "file"),
)

#: Who is told of a job's end, and how that stands. When the first attempt is due is written with the end itself.
webhooks = Table(
    "webhooks",
    metadata,
    Column("job_id", String(36), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("url", Text, nullable=False),
    Column("secret", String(100), nullable=False),  # never in an answer
    Column("state", String(16), nullable=False),  # webhooks.schemas.DeliveryState
    Column("attempts", Integer, nullable=False),  # begun; who makes one writes under its number
    Column("due_at", UtcDateTime),  # the next attempt; null before the job's end, and when there will be none
    Column("error", Text),  # of the newest attempt
    Index(None, "due_at"),
)

#: Where the files of jobs and comparisons lie in a bucket, if they are kept in one.
objects = Table(
    "objects",
    metadata,
    Column("job_id", String(36), primary_key=True),
    Column("name", String(64), primary_key=True),
    Column("key", String(200), nullable=False, unique=True),
    Column("size", BigInteger, nullable=False),  # bytes
)

#: The states that a job came to, each written with the state itself; ids say the order.
job_events = Table(
    "job_events",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("job_id", String(36), ForeignKey("jobs.id", ondelete="CASCADE"), nullable=False),
    Column("state", String(16), nullable=False),
    Column("at", UtcDateTime, nullable=False),
    Index(None, "job_id", "id"),
    sqlite_autoincrement=True,  # an id is not given again when jobs are deleted
)

#: First answers to requests that came with an Idempotency-Key.
answers = Table(
    "answers",
    metadata,
    Column("key", String(255), primary_key=True),
    Column("digest", String(64), nullable=False),  # of the request
    Column("answer", JSON, nullable=False),
    Column("created_at", UtcDateTime, nullable=False),
)

#: Who may do what. None is ever deleted: from the first one on, every request needs one.
tokens = Table(
    "tokens",
    metadata,
    Column("id", String(36), primary_key=True),  # sorts by time of creation
    Column("name", String(200), nullable=False),
    Column("owner", String(200), nullable=False, server_default=""),  # who asks with it
    Column("digest", String(64), nullable=False, unique=True),  # SHA-256 of the token
    Column("scope", String(8), nullable=False),  # access.tokens.Scope
    Column("created_at", UtcDateTime, nullable=False),
    Column("expires_at", UtcDateTime),
    Column("revoked_at", UtcDateTime),
)

comparisons = Table(
    "comparisons",
    metadata,
    Column("id", String(36), primary_key=True),  # sorts by time of creation
    Column("owner", String(200), nullable=False, server_default=""),  # its jobs', too
    Column("name", String(200), nullable=False),
    Column("scene", JSON, nullable=False),
    Column("vary", JSON, nullable=False),  # field -> kinds
    Column("seconds", Float, nullable=False),  # of rendering, for each variant
    Column("reference", String(71)),  # as of a job
    Column("device", String(64), nullable=False),
    Column("created_at", UtcDateTime, nullable=False),
    Column("variants", JSON, nullable=False),  # list of job, label and choices
)

#: Sweeps; what becomes of one is said by its jobs.
batches = Table(
    "batches",
    metadata,
    Column("id", String(36), primary_key=True),  # sorts by time of creation
    Column("owner", String(200), nullable=False, server_default=""),  # its jobs', too
    Column("name", String(200), nullable=False),
    Column("scene", JSON, nullable=False),  # that is swept
    Column("product", JSON, nullable=False),  # path -> values, as asked for
    Column("zip", JSON, nullable=False),  # path -> values, as asked for
    Column("created_at", UtcDateTime, nullable=False),
)

#: Uploaded files of every type.
volumes = Table(
    "volumes",
    metadata,
    Column("id", String(71), primary_key=True),  # sha256:<64 hex>, which is also the name of the file
    Column("entry", String(36), nullable=False, unique=True),  # sorts by time of upload
    Column("owner", String(200), nullable=False, server_default=""),  # who uploaded it first
    Column("name", String(200), nullable=False),
    Column("size", BigInteger, nullable=False),
    Column("created_at", UtcDateTime, nullable=False),
    Column("used_at", UtcDateTime),  # when it was uploaded last
    Column("type", String(16), nullable=False),  # volume, mesh or picture: what of the following it has
    Column("grids", JSON, nullable=False),  # list of woodcock.formats.GridInfo
    Column("triangles", Integer),
    Column("width", Integer),
    Column("height", Integer),
)

#: Outcomes of stability checks; of each device the newest counts.
stability_checks = Table(
    "stability_checks",
    metadata,
    Column("id", String(36), primary_key=True),  # sorts by time of the end
    Column("fingerprint", String(64), nullable=False),  # devices.service.Found.fingerprint
    Column("identity", Text, nullable=False),  # platform, name, driver and their versions, for people
    Column("version", String(64), nullable=False),  # Woodcock's
    Column("passed", Boolean, nullable=False),
    Column("started_at", UtcDateTime, nullable=False),
    Column("finished_at", UtcDateTime, nullable=False),
    Column("rows", JSON, nullable=False),  # list of devices.schemas.StabilityRow
    Index(None, "fingerprint", "id"),
)
