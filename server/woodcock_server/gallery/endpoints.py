"""/, /renders/{id}, /batches/{id}, /fleet and /web"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse
from fastapi.staticfiles import StaticFiles

WEB = Path(str(files("woodcock_client") / "web"))

router = APIRouter(include_in_schema=False)
static = StaticFiles(directory=WEB)


@router.get("/")
@router.get("/renders/{id}")
@router.get("/fleet")
@router.get("/batches/{id}")
def page() -> FileResponse:
    """One page shows them all; it reads its own address."""
    return FileResponse(WEB / "index.html", headers={"Cache-Control": "no-cache"})
