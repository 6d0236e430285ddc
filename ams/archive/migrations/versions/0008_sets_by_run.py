"""The sets of a run without going through all sets: a history asks what the sensors of its runs changed alike."""

from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_index("ix_sets_run_id", "sets", ["run_id"])


def downgrade() -> None:
    op.drop_index("ix_sets_run_id", "sets")
