"""Batches and comparisons have owners, those of their jobs."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"


def upgrade() -> None:
    for table, column in (("batches", "batch"), ("comparisons", "comparison")):
        op.add_column(table, sa.Column("owner", sa.String(200), nullable=False, server_default=""))
        of_its_jobs = f"SELECT min(owner) FROM jobs WHERE jobs.{column} = {table}.id"
        op.execute(f"UPDATE {table} SET owner = coalesce(({of_its_jobs}), '')")


def downgrade() -> None:
    for table in ("comparisons", "batches"):
        op.drop_column(table, "owner")
