"""Sets with their whole document, and their coefficients for histories."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "sets",
        sa.Column("sha256", sa.String(64), primary_key=True),
        sa.Column("sensor", sa.Text, nullable=False, index=True),
        sa.Column("serial", sa.Text),
        sa.Column("model", sa.Text, nullable=False),
        sa.Column("convention", sa.Text, nullable=False),
        sa.Column("status", sa.Text, nullable=False),
        sa.Column("simulated", sa.Boolean, nullable=False),
        sa.Column("run_id", sa.Text),
        sa.Column("software_version", sa.Text, nullable=False),
        sa.Column("created_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("published_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("document", sa.Text, nullable=False),
    )
    op.create_table(
        "coefficients",
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), primary_key=True),
        sa.Column("axis", sa.Text, primary_key=True),
        sa.Column("name", sa.Text, primary_key=True),
        sa.Column("unit", sa.Text, nullable=False),
        sa.Column("value", sa.Double),
        sa.Column("standard_uncertainty", sa.Double),
    )


def downgrade() -> None:
    op.drop_table("coefficients")
    op.drop_table("sets")
