"""How long the parts of a run's steps were expected to take and took: what the next estimate learns from."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "durations",
        sa.Column("journal_sha256", sa.String(64), primary_key=True),
        sa.Column("part", sa.Text, primary_key=True),
        sa.Column("rig", sa.Text, nullable=False, index=True),
        sa.Column("simulated", sa.Boolean, nullable=False),
        sa.Column("ended_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("steps", sa.Integer, nullable=False),
        sa.Column("expected_s", sa.Double, nullable=False),
        sa.Column("measured_s", sa.Double, nullable=False),
        sa.Column("expected_s2", sa.Double, nullable=False),
        sa.Column("rest_s2", sa.Double, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("durations")
