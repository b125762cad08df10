"""Uploaded files may be meshes and pictures."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

_ADDED = (
    # What was uploaded before is a volume.
    sa.Column("type", sa.String(16), nullable=False, server_default="volume"),
    sa.Column("triangles", sa.Integer),
    sa.Column("width", sa.Integer),
    sa.Column("height", sa.Integer),
)


def upgrade() -> None:
    for column in _ADDED:
        op.add_column("volumes", column.copy())


def downgrade() -> None:
    for column in _ADDED:
        op.drop_column("volumes", column.name)
