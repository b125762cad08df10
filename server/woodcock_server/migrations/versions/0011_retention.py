"""Which files jobs name, so that those that none does can go; jobs can be pinned."""

import json
import re

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    op.add_column("jobs", sa.Column("pinned", sa.Boolean, nullable=False, server_default=sa.false()))
    op.create_index("ix_jobs_finished_at_id", "jobs", ["finished_at", "id"])
    op.add_column("volumes", sa.Column("used_at", sa.DateTime(timezone=True)))
    op.execute("UPDATE volumes SET used_at = created_at")
    op.create_table(
        "job_files",
        sa.Column("job_id", sa.String(36), nullable=False),
        sa.Column("file", sa.String(71), nullable=False),
        sa.PrimaryKeyConstraint("job_id", "file", name="pk_job_files"),
        sa.ForeignKeyConstraint(["job_id"], ["jobs.id"], name="fk_job_files_job_id", ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["file"], ["volumes.id"], name="fk_job_files_file"),
    )
    op.create_index("ix_job_files_file", "job_files", ["file"])
    connection = op.get_bind()
    known = set(connection.execute(sa.text("SELECT id FROM volumes")).scalars())
    for job_id, scene, reference in connection.execute(sa.text("SELECT id, scene, reference FROM jobs")).all():
        named = re.findall("sha256:[0-9a-f]{64}", json.dumps([scene, reference]))
        for file in sorted(known & set(named)):
            connection.execute(
                sa.text("INSERT INTO job_files (job_id, file) VALUES (:job_id, :file)"),
                {"job_id": job_id, "file": file},
            )


def downgrade() -> None:
    op.drop_table("job_files")
    op.drop_column("volumes", "used_at")
    op.drop_index("ix_jobs_finished_at_id", "jobs")
    op.drop_column("jobs", "pinned")
