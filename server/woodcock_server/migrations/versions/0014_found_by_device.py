"""Jobs are found by the devices that rendered them, and by their integrator."""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"

#: Rows that are read at a time: each has all that its devices said.
AT_ONCE = 500

jobs = sa.table("jobs", sa.column("id"), sa.column("usage", sa.JSON), sa.column("integrator"))
job_devices = sa.table("job_devices", sa.column("job_id"), sa.column("device"))


def upgrade() -> None:
    op.add_column("jobs", sa.Column("integrator", sa.String(64)))
    op.create_table(
        "job_devices",
        sa.Column("job_id", sa.String(36), nullable=False),
        sa.Column("device", sa.String(64), nullable=False),
        sa.ForeignKeyConstraint(["job_id"], ["jobs.id"], name="fk_job_devices_job_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("job_id", "device", name="pk_job_devices"),
    )
    connection = op.get_bind()
    ids = list(connection.execute(sa.select(jobs.c.id)).scalars())
    for first in range(0, len(ids), AT_ONCE):
        query = sa.select(jobs.c.id, jobs.c.usage).where(jobs.c.id.in_(ids[first : first + AT_ONCE]))
        used = {job_id: usage for job_id, usage in connection.execute(query) if usage}
        if used:
            connection.execute(
                sa.update(jobs).where(jobs.c.id == sa.bindparam("job")).values(integrator=sa.bindparam("kind")),
                [{"job": job_id, "kind": _integrator(usage)} for job_id, usage in used.items()],
            )
            rows = [{"job_id": job_id, "device": device} for job_id, usage in used.items() for device in usage]
            connection.execute(sa.insert(job_devices), rows)
    op.create_index("ix_job_devices_device_job_id", "job_devices", ["device", "job_id"])
    op.create_index("ix_jobs_integrator_id", "jobs", ["integrator", "id"])
    op.create_index("ix_jobs_state_id", "jobs", ["state", "id"])


def _integrator(usage: dict[str, Any]) -> Any:
    return next(iter(usage.values()))["kinds"]["integrator"][0]


def downgrade() -> None:
    op.drop_index("ix_jobs_state_id", "jobs")
    op.drop_index("ix_jobs_integrator_id", "jobs")
    op.drop_table("job_devices")
    op.drop_column("jobs", "integrator")
