"""Batches: sweeps of a scene, and which jobs are at which of their points."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    op.create_table(
        "batches",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("scene", sa.JSON, nullable=False),
        sa.Column("product", sa.JSON, nullable=False),
        sa.Column("zip", sa.JSON, nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_batches"),
    )
    # As text: SQLite takes a constraint with its column alone, and Alembic writes them apart.
    op.execute("ALTER TABLE jobs ADD COLUMN batch VARCHAR(36) CONSTRAINT fk_jobs_batch REFERENCES batches (id)")
    op.add_column("jobs", sa.Column("point", sa.JSON))
    op.create_index("ix_jobs_batch_id", "jobs", ["batch", "id"])


def downgrade() -> None:
    op.drop_index("ix_jobs_batch_id", "jobs")
    op.drop_column("jobs", "point")
    op.drop_column("jobs", "batch")
    op.drop_table("batches")
