"""A page as one text: template, style and script inside, and a policy under which nothing else can load or run."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"
#: Of pages, in this order, after that of figures.
STYLES = ("page", "flip", "numbers", "screens")


@cache
def _environment() -> Environment:
    return Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True)


@cache
def figure_style() -> str:
    return (TEMPLATES / "figure.css").read_text()


@cache
def _style() -> str:
    return figure_style() + "".join((TEMPLATES / f"{name}.css").read_text() for name in STYLES)


@cache
def _script() -> str:
    return (TEMPLATES / "flip.js").read_text()


@cache
def policy() -> str:
    """The Content-Security-Policy of every page, which says so itself; a server may send the same."""
    style, script = (
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (_style(), _script())
    )
    parts = ("default-src 'none'", "img-src data:", f"style-src 'sha256-{style}'", f"script-src 'sha256-{script}'")
    return "; ".join((*parts, "base-uri 'none'", "form-action 'none'"))


def document(template: str, title: str, **values: Any) -> str:
    """A template of this folder, filled in; every string is escaped but Markup."""
    fixed = {"policy": policy(), "style": Markup(_style()), "script": Markup(_script())}  # our own files
    return _environment().get_template(template).render(title=title, **fixed, **values)
