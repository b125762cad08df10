"""What the gallery's folder holds."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from pathlib import Path

from woodcock.generic.whole import KINDS
from woodcock.laws import OF_RANDOM_PATHS, WITHOUT_NOISE

WEB = Path(__file__).parents[2] / "client" / "woodcock_client" / "web"


def test_vendored_modules_are_those_that_are_listed() -> None:
    vendor = WEB / "vendor"
    versions = (vendor / "VERSIONS.md").read_text()
    listed = dict(re.findall(r"^\| `([\w./-]+)` .* `([0-9a-f]{64})` \|$", versions, re.MULTILINE))
    found = {str(path.relative_to(vendor)): path for path in vendor.rglob("*") if path.is_file()}
    modules = {name: path for name, path in found.items() if name.endswith(".mjs")}
    assert listed == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in modules.items()}
    licences = set(re.findall(r"\(`([\w./-]+\.LICENSE)`\)", versions))
    assert set(found) == {*modules, *licences, "VERSIONS.md"}


def test_the_policy_admits_the_import_map_and_the_map_names_files() -> None:
    page = (WEB / "index.html").read_text()
    found = re.search(r'<script type="importmap">(.*?)</script>', page, re.DOTALL)
    assert found
    assert f"'sha256-{base64.b64encode(hashlib.sha256(found[1].encode()).digest()).decode()}'" in page
    for address in json.loads(found[1])["imports"].values():
        assert (WEB.parent / address[1:]).is_file()


def test_pages_share_no_class_but_those_of_the_house() -> None:
    """All stylesheets are loaded on every page: what one says of a class must not befall another's."""
    owners: dict[str, set[str]] = {}
    for sheet in WEB.glob("*/*.css"):
        rules = re.sub(r"/\*.*?\*/|:\w+\([^()]*\)", "", sheet.read_text(), flags=re.DOTALL)
        for selector in (each for group in re.findall(r"([^{}]+)\{", rules) for each in group.split(",")):
            if named := re.match(r"\s*\.([\w-]+)", selector):
                owners.setdefault(named[1], set()).add(sheet.parent.name)
    house = set(re.findall(r"\.([a-z][\w-]*)", (WEB / "style.css").read_text()))
    assert {name: pages for name, pages in owners.items() if len(pages) > 1 and name not in house} == {}


def test_the_report_has_a_word_for_everything_that_a_scene_may_do_without() -> None:
    source = (WEB / "render/lean.js").read_text()
    table = source[source.index("const CONCEPTS") : source.index("\n};")]
    concepts = re.split(r"\n  (\w+): \[", table)[1:]
    words = {
        name: set(re.findall(r"(\w+): \"", body)) for name, body in zip(concepts[::2], concepts[1::2], strict=True)
    }
    assert words.pop("majorant") == {"global", *KINDS["majorant"]}
    assert words == {name: set(KINDS[name]) for name in words}
    assert set(KINDS) - set(words) == {"integrator", "storage", "majorant"}


def test_the_certificate_has_words_for_every_law() -> None:
    known = re.findall(r'^  "?([\w ]+?)"?: \{$', (WEB / "render/meanings.js").read_text(), re.MULTILINE)
    assert {law.name for law in (*OF_RANDOM_PATHS, *WITHOUT_NOISE)} < set(known)
