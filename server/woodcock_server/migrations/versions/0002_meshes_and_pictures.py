"""Uploaded files may be meshes and pictures."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    # What was uploaded before is a volume.
    op.add_column("volumes", sa.Column("type", sa.String(16), nullable=False, server_default="volume"))
    for name in ("triangles", "width", "height"):
        op.add_column("volumes", sa.Column(name, sa.Integer))


def downgrade() -> None:
    for name in ("type", "triangles", "width", "height"):
        op.drop_column("volumes", name)
