"""Jobs can go on from others' samples."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    op.add_column("jobs", sa.Column("extends", sa.String(36)))


def downgrade() -> None:
    op.drop_column("jobs", "extends")
