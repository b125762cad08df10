"""Jobs, uploads and tokens have owners; who renders a job is its holder. How much room results take is kept."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    op.execute("ALTER TABLE jobs RENAME COLUMN owner TO holder")
    for table in ("jobs", "volumes", "tokens"):
        op.add_column(table, sa.Column("owner", sa.String(200), nullable=False, server_default=""))
    op.execute("UPDATE tokens SET owner = name")
    op.add_column("jobs", sa.Column("paths", sa.BigInteger, nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("size", sa.BigInteger))
    op.create_index("ix_jobs_started_at_owner_seconds", "jobs", ["started_at", "owner", "seconds"])
    op.create_index("ix_jobs_owner_state_paths", "jobs", ["owner", "state", "paths"])
    op.create_index("ix_jobs_owner_size", "jobs", ["owner", "size"])


def downgrade() -> None:
    for index in ("ix_jobs_owner_size", "ix_jobs_owner_state_paths", "ix_jobs_started_at_owner_seconds"):
        op.drop_index(index, "jobs")
    op.drop_column("jobs", "size")
    op.drop_column("jobs", "paths")
    for table in ("tokens", "volumes", "jobs"):
        op.drop_column(table, "owner")
    op.execute("ALTER TABLE jobs RENAME COLUMN holder TO owner")
