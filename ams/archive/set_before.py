"""The set that a sensor had before a calibration: what it is found by, and held against."""

from sqlalchemy import Connection, not_, or_, select

from ams.archive.approvals import is_withdrawn
from ams.archive.quarantines import is_quarantined
from ams.archive.sets import stored_set
from ams.archive.tables import SETS
from ams.sets.coefficients import CoefficientSet


def set_before(connection: Connection, new: CoefficientSet) -> CoefficientSet | None:
    """Return the latest set of this sensor from an earlier calibration.

    A simulated set never stands before a measured one, nor one that is in quarantine or was withdrawn before any.
    """
    query = select(SETS.c.sha256).where(
        SETS.c.sensor == new.sensor, SETS.c.created_utc < new.created_utc, SETS.c.simulated == new.is_simulated,
        not_(is_quarantined(SETS.c.sha256)), not_(is_withdrawn(SETS.c.sha256)),
    )  # fmt: skip
    run_id = new.provenance["run_id"]
    if run_id is not None:
        query = query.where(or_(SETS.c.run_id.is_(None), SETS.c.run_id != run_id))
    latest = query.order_by(SETS.c.created_utc.desc(), SETS.c.published_utc.desc(), SETS.c.sha256.desc()).limit(1)
    sha256 = connection.execute(latest).scalar()
    return None if sha256 is None else stored_set(connection, sha256)
