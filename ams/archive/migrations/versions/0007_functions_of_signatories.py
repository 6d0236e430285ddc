"""The function of who signed, beside the signature: a certificate identifies whoever authorises it."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "functions",
        sa.Column("sequence", sa.Integer, sa.ForeignKey("signatures.sequence"), primary_key=True, autoincrement=False),
        sa.Column("function", sa.Text, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("functions")
