"""What is sent as text reaches no compiler, no path and no query: only the kinds that the schema knows, and numbers."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest
from pydantic import ValidationError
from starlette.testclient import TestClient

from woodcock.device import find
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.render import program_of, read_file
from woodcock.scene import Scene, SceneError

Make = Callable[..., dict[str, Any]]

#: In every text that is sent; in no text of ours.
MARK = "w00dc0ck"
CORPUS = [
    f"{MARK}",
    f'"); system("touch {MARK}"); //',
    f"*/ __kernel void {MARK}() {{}} /*",
    f"\\\n#include <{MARK}>",
    f"\n#pragma {MARK}\n",
    f"-D{MARK}=1 -I/{MARK}",
    f"{{{{ {MARK} }}}}{{% include '{MARK}' %}}${{{MARK}}}%({MARK})s",
    f"'; DROP TABLE jobs; -- {MARK}",
    f"' OR 1=1 -- {MARK}",
    f"../../../../{MARK}",
    f"/etc/passwd#{MARK}",
    f"file:///{MARK}",
    f"sha256:{MARK}",
    f"sha256:../../{MARK}",
    f"<script>alert('{MARK}')</script>",
    f"$(touch {MARK})`touch {MARK}`|touch {MARK}",
    f"{MARK}\u202e\u2066\u200b\ufeff",
    f"{MARK}é́ｆｕｌｌｗｉｄｔｈ😀",
    f"{MARK}" * 50,
    f"__proto__{MARK}",
    f"{MARK}\udc80",
    f"{MARK}\x00\x1b[2J",
]
#: In place of numbers.
NUMBERS: list[Any] = [
    "1", "1e3", "0x10", f"1; {MARK}", True, None, [], {}, [1], 10**400, -(10**400), float("nan"), float("inf"), 1e308,
    -1e308, 5e-324, -0.0, 2**63, -(2**63) - 1, 2**31,
]  # fmt: skip

GREY = {"kind": "diffuse", "reflectance": 0.5}


@pytest.fixture(scope="module")
def rich(make_scene: Make) -> dict[str, Any]:
    """A scene with many places for text and numbers."""
    return make_scene(
        size=8,
        integrator={"kind": "volumetric_path"},
        layers=["albedo"],
        majorant={"kind": "global"},
        free_flight={"kind": "delta"},
        surfaces=[{"kind": "sphere", "center": [0, 0, 0], "radius": 0.5, "material": GREY}],
        seed=3,
    )


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        if isinstance(item, dict | list):
            yield from leaves(item, (*path, key))
        else:
            yield (*path, key), item


def put(scene: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed = copy.deepcopy(scene)
    part: Any = changed
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return changed


def submitted(client: TestClient, body: dict[str, Any]) -> int:
    """The status; of a refusal, one that is a problem and says nothing of the server's insides."""
    content = json.dumps(body).encode()
    answer = client.post("/api/v1/jobs", content=content, headers={"Content-Type": "application/json"})
    if answer.status_code != 201:
        assert answer.status_code == 422, answer.text
        assert answer.headers["content-type"] == "application/problem+json"
        assert "Traceback" not in answer.text
    return answer.status_code


def program(scene: dict[str, Any]) -> str:
    device, layout = find(), lay_out(Scene.model_validate(scene), read_file)
    return program_of(layout, device, best_lanes(device, probe(device)))[0].text


def test_no_text_of_a_scene_comes_into_its_program(client: TestClient, rich: dict[str, Any], data: Path) -> None:
    assert submitted(client, {"scene": rich}) == 201
    texts = [path for path, value in leaves(rich) if isinstance(value, str)]
    assert len(texts) > 8
    taken = 0
    for path in texts:
        for text in CORPUS:
            scene = put(rich, path, text)
            if submitted(client, {"scene": scene}) == 201:
                taken += 1
                assert MARK not in program(scene)
            with pytest.raises(ValidationError):
                Scene.model_validate(scene)
    assert taken == 0, "what a scene says in words are kinds"
    assert not [path for path in data.rglob("*") if MARK in path.name]


@pytest.mark.parametrize("field", ["name", "tags", "device", "reference", "key of the scene", "key of a part"])
def test_text_beside_a_scene_is_kept_as_it_came_or_refused(
    client: TestClient, rich: dict[str, Any], field: str
) -> None:
    for text in CORPUS:
        body: dict[str, Any] = {"scene": rich}
        match field:
            case "tags":
                body["tags"] = [text]
            case "key of the scene":
                body["scene"] = {**rich, text: 1}
            case "key of a part":
                body["scene"] = put(rich, ("camera", text), 1)
            case _:
                body[field] = text
        if submitted(client, body) == 201:
            assert field in ("name", "tags")
            found = client.get("/api/v1/jobs", params={"limit": 1, "text": text} if field == "name" else {"tag": text})
            (job,) = found.json()["items"][:1]
            assert job[field] == body[field]


def test_numbers_are_numbers_and_change_no_program(client: TestClient, rich: dict[str, Any]) -> None:
    plain = program(rich)
    assert len(plain) > 1000
    numbers = [path for path, value in leaves(rich) if isinstance(value, int | float) and not isinstance(value, bool)]
    assert len(numbers) > 20
    same = 0
    for path in numbers:
        for number in NUMBERS:
            scene = put(rich, path, number)
            try:
                Scene.model_validate(scene)
            except ValidationError:
                assert submitted(client, {"scene": scene}) == 422
                continue
            if submitted(client, {"scene": scene}) == 201 and path[-1] not in ("samples", "width", "height"):
                # Of lengths that float32 does not have: its job will fail, and say so.
                with suppress(SceneError), np.errstate(all="ignore"):
                    text = program(scene)
                    same += text == plain
                    assert MARK not in text
    assert same > 20, "numbers are uploaded, not compiled"


@pytest.mark.parametrize("text", CORPUS)
@pytest.mark.parametrize(
    "path", ["jobs/{}", "jobs/{}/image.exr", "jobs/{}/events", "volumes/{}", "comparisons/{}", "devices/{}/stability"]
)
def test_ids_that_are_none_are_not_found(client: TestClient, path: str, text: str, data: Path) -> None:
    answer = client.get("/api/v1/" + path.format(quote(text.encode("utf-8", "surrogateescape"), safe="")))
    assert answer.status_code in (404, 405), answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert str(data) not in answer.text


@pytest.mark.parametrize("query", ["cursor", "state", "tag", "text", "owner", "since", "limit"])
def test_queries_find_nothing_that_they_do_not_mean(client: TestClient, query: str) -> None:
    for text in CORPUS:
        answer = client.get("/api/v1/jobs", params={query: text.encode("utf-8", "surrogateescape")})  # type: ignore[dict-item]
        assert answer.status_code in (200, 422), answer.text
        if answer.status_code == 200:
            for job in answer.json()["items"]:
                assert text in job["name"] or text in job["tags"]
