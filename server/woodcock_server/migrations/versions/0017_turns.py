"""What an owner had lately is looked up for those who wait alone."""

from alembic import op

revision = "0017"
down_revision = "0016"


def upgrade() -> None:
    op.create_index("ix_jobs_owner_started_at_seconds", "jobs", ["owner", "started_at", "seconds"])
    op.drop_index("ix_jobs_started_at_owner_seconds", "jobs")


def downgrade() -> None:
    op.create_index("ix_jobs_started_at_owner_seconds", "jobs", ["started_at", "owner", "seconds"])
    op.drop_index("ix_jobs_owner_started_at_seconds", "jobs")
