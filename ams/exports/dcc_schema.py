"""A DCC against the official schemas, offline: they lie in a folder of the user's, nothing is fetched.

Source: dcc.xsd 3.2.1, SI_Format.xsd 2.1.0 and the XML signature's schema, published by PTB under LGPL-3.
"""

from pathlib import Path
from typing import Any

from ams.errors import SetError
from ams.exports.optional_libraries import library
from ams.whole_file import read_whole

SCHEMA = "dcc_3_2_1.xsd"
IMPORTED = {
    "https://ptb.de/si/v2.1.0/SI_Format.xsd": "dsi_2_1_0.xsd",
    "https://www.ptb.de/dcc/d-sig/xmldsig-core-schema.xsd": "ds_0_1.xsd",
}
SHOWN_FAULTS = 3


def check_against_schemas(path: Path, folder: Path) -> None:
    """Refuse a file that the schemas do not allow, with its lines.

    Raises: SetError, also for schemas that are not there.
    """
    etree = library("lxml.etree", str(path))
    try:
        schema = _schema(folder, etree)
    except (OSError, etree.XMLSyntaxError, etree.XMLSchemaParseError) as error:
        raise SetError(
            f"{folder}: the DCC schemas cannot be read: {error}; needed are {SCHEMA}, {', '.join(IMPORTED.values())}; "
            f"{path} was not validated; put them there, or unset CALRIG_DCC_SCHEMAS"
        ) from error
    if not schema.validate(etree.fromstring(read_whole(path))):
        faults = [f"line {error.line}: {error.message}" for error in schema.error_log]
        raise SetError(f"{path}: is no DCC by {SCHEMA}: {'; '.join(faults[:SHOWN_FAULTS])}; export it again")


def _schema(folder: Path, etree: Any) -> Any:
    class Offline(etree.Resolver):  # type: ignore[misc]  # lxml has no types
        def resolve(self, url: str, _public_id: str, context: Any) -> Any:
            return self.resolve_string((folder / IMPORTED[url]).read_bytes(), context)

    parser = etree.XMLParser(no_network=True)
    parser.resolvers.add(Offline())
    return etree.XMLSchema(etree.fromstring((folder / SCHEMA).read_bytes(), parser))
