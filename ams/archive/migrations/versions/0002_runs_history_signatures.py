"""Runs, standards, as found and as left, signatures, certificates; points of history; the chain over all of it.

What an archive of 0001 holds is told by the chain's first record, and its sets become points of history.
"""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    _history()
    _runs()
    _people()
    _take_over()


def downgrade() -> None:
    for name in (
        "records", "certificates", "signatures", "adjustments", "uses", "standards", "runs", "points",
    ):  # fmt: skip
        op.drop_table(name)


def _history() -> None:
    op.create_table(
        "points",
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), primary_key=True),
        sa.Column("rig", sa.Text, nullable=False),
        sa.Column("axes", sa.Text, nullable=False),
        sa.Column("sensitivity_name", sa.Text, nullable=False),
        sa.Column("check_sensor", sa.Boolean, nullable=False),
        sa.Column("gravity_mps2", sa.Double, nullable=False),
        sa.Column("numbers", sa.LargeBinary, nullable=False),
    )
    op.create_table(
        "adjustments",
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), primary_key=True),
        sa.Column("previous_sha256", sa.String(64), sa.ForeignKey("sets.sha256")),
        sa.Column("as_found", sa.Text),
        sa.Column("as_left", sa.Text),
        sa.Column("as_found_error_deg", sa.Double),
        sa.Column("as_left_error_deg", sa.Double),
        sa.Column("document", sa.Text, nullable=False),
    )
    op.create_table(
        "records",
        sa.Column("sequence", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("detail", sa.Text, nullable=False),
        sa.Column("previous", sa.String(64), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
    )


def _runs() -> None:
    op.create_table(
        "runs",
        sa.Column("journal_sha256", sa.String(64), primary_key=True),
        sa.Column("run_id", sa.Text, nullable=False, index=True),
        sa.Column("title", sa.Text, nullable=False),
        sa.Column("rig", sa.Text, nullable=False),
        sa.Column("operator", sa.Text, nullable=False),
        sa.Column("simulated", sa.Boolean, nullable=False),
        sa.Column("started_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ended_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("folder", sa.Text, nullable=False),
        sa.Column("software_version", sa.Text, nullable=False),
        sa.Column("published_utc", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "standards",
        sa.Column("serial", sa.Text, primary_key=True),
        sa.Column("certificate", sa.Text, primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("due", sa.Date),
        sa.Column("uncertainty", sa.Text, nullable=False),
    )
    op.create_table(
        "uses",
        sa.Column("journal_sha256", sa.String(64), sa.ForeignKey("runs.journal_sha256"), primary_key=True),
        sa.Column("serial", sa.Text, primary_key=True),
        sa.Column("certificate", sa.Text, primary_key=True),
        sa.Column("overridden_by", sa.Text),
        sa.Column("override_reason", sa.Text),
    )


def _people() -> None:
    op.create_table(
        "signatures",
        sa.Column("sequence", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), nullable=False, index=True),
        sa.Column("role", sa.Text, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("signed_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("comment", sa.Text, nullable=False),
    )
    op.create_table(
        "certificates",
        sa.Column("number", sa.Text, primary_key=True),
        sa.Column("sha256", sa.String(64), sa.ForeignKey("sets.sha256"), nullable=False, index=True),
        sa.Column("file_sha256", sa.String(64), nullable=False),
        sa.Column("issued_by", sa.Text, nullable=False),
        sa.Column("issued_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("amends", sa.Text, sa.ForeignKey("certificates.number")),
        sa.Column("reason", sa.Text, nullable=False),
    )


def _take_over() -> None:
    from ams.archive.upgrade_to_0002 import upgrade_from_0001

    upgrade_from_0001(op.get_bind())
