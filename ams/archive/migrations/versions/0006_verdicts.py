"""The verdict that a set states, beside its document: a list of many sets reads a word and not all of their text."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    from ams.archive.upgrade_to_0006 import upgrade_from_0005

    op.create_table(
        "verdicts",
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), primary_key=True),
        sa.Column("verdict", sa.Text, nullable=False),
    )
    upgrade_from_0005(op.get_bind())


def downgrade() -> None:
    op.drop_table("verdicts")
