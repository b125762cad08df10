"""Pictures are held against references, and it is measured where the time goes."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    op.add_column("jobs", sa.Column("reference", sa.String(71)))
    op.add_column("jobs", sa.Column("reached", sa.Float))
    op.add_column("jobs", sa.Column("spent", sa.JSON, nullable=False, server_default="{}"))
    op.add_column("jobs", sa.Column("kept", sa.JSON))


def downgrade() -> None:
    op.drop_column("jobs", "kept")
    op.drop_column("jobs", "spent")
    op.drop_column("jobs", "reached")
    op.drop_column("jobs", "reference")
