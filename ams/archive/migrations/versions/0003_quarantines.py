"""Sets that a finding of their run takes away: they stay as they are, and never stand before a later one."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "quarantines",
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), primary_key=True),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("quarantined_utc", sa.DateTime(timezone=True), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("quarantines")
