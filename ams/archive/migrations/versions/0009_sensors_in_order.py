"""The sensors of a run, and all sensors, in the order of their names: so many behind one are found without the others.

PostgreSQL orders text by the language that a database was made for, and charts by code points.
"""

from alembic import op
from sqlalchemy import text

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    is_sqlite = op.get_bind().dialect.name == "sqlite"
    op.create_index("ix_sets_run_sensor", "sets", ["run_id", "sensor" if is_sqlite else text('sensor COLLATE "C"')])
    if not is_sqlite:
        op.create_index("ix_sets_sensor_in_order", "sets", [text('sensor COLLATE "C"')])
    op.drop_index("ix_sets_run_id", "sets")


def downgrade() -> None:
    op.create_index("ix_sets_run_id", "sets", ["run_id"])
    if op.get_bind().dialect.name != "sqlite":
        op.drop_index("ix_sets_sensor_in_order", "sets")
    op.drop_index("ix_sets_run_sensor", "sets")
