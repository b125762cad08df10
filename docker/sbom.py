"""What an image is made of, as CycloneDX: the distributions of a virtual environment and Debian's packages."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packageurl import PackageURL

FIELDS = ("Package", "Version", "Architecture")


def installed(status: Path) -> list[Component]:
    """Debian's packages, from dpkg's record of them."""
    components = []
    for paragraph in status.read_text().split("\n\n"):
        fields = dict(line.split(": ", 1) for line in paragraph.splitlines() if ": " in line and line[0] != " ")
        if fields.get("Status", "").endswith(" installed"):
            name, version, architecture = (fields[field] for field in FIELDS)
            purl = PackageURL("deb", "debian", name, version, {"arch": architecture})
            components.append(
                Component(name=name, version=version, type=ComponentType.LIBRARY, bom_ref=str(purl), purl=purl)
            )
    return components


def main(environment: str, status: str, out: str) -> None:
    command = [str(Path(sys.executable).with_name("cyclonedx-py")), "environment", "--spec-version", "1.6", environment]
    python = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    bom: Bom = Bom.from_json(json.loads(python))
    bom.components.update(installed(Path(status)))
    text = JsonV1Dot6(bom).output_as_string(indent=1)
    if fault := JsonStrictValidator(SchemaVersion.V1_6).validate_str(text):
        sys.exit(f"Not valid CycloneDX: {fault}")
    Path(out).write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
