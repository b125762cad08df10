"""Who lost a stream of events learns what he missed."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    op.create_table(
        "job_events",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("job_id", sa.String(36), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_job_events"),
        sa.ForeignKeyConstraint(["job_id"], ["jobs.id"], name="fk_job_events_job_id", ondelete="CASCADE"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_job_events_job_id_id", "job_events", ["job_id", "id"])
    # Jobs from before have their present state alone.
    op.execute(
        "INSERT INTO job_events (job_id, state, at)"
        " SELECT id, state, COALESCE(finished_at, started_at, created_at) FROM jobs ORDER BY id"
    )


def downgrade() -> None:
    op.drop_table("job_events")
