"""Devices are checked, and jobs may ask for one."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    # Jobs of before asked for no device.
    op.add_column("jobs", sa.Column("device", sa.String(64), nullable=False, server_default="any"))
    op.create_table(
        "stability_checks",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("fingerprint", sa.String(64), nullable=False),
        sa.Column("identity", sa.Text, nullable=False),
        sa.Column("version", sa.String(64), nullable=False),
        sa.Column("passed", sa.Boolean, nullable=False),
        sa.Column("started_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("finished_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("rows", sa.JSON, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_stability_checks"),
    )
    op.create_index("ix_stability_checks_fingerprint_id", "stability_checks", ["fingerprint", "id"])


def downgrade() -> None:
    op.drop_table("stability_checks")
    op.drop_column("jobs", "device")
