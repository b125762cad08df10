"""What may vary: the fields of a scene that choose an estimator, and the scenes that choices make."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count, product
from math import prod
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from woodcock.scene import Scene, explain

#: Fields of a scene that say how it is solved, and not what it shows.
FIELDS = ("majorant", "free_flight", "transmittance", "integrator")
MOST_VARIANTS = 64


class CompareError(ValueError):
    """A comparison that cannot be made; one sentence."""


@dataclass(frozen=True)
class Variant:
    """choices: the kind of every field that varies; label: they in words, such as `ratio, grid`."""

    label: str
    choices: dict[str, str]
    scene: Scene


def kinds(field: str) -> dict[str, type[BaseModel]]:
    """The kinds that a field of a scene may be of, in the scene's order."""
    return {str(model.model_fields["kind"].default): model for model in _models(Scene.model_fields[field].annotation)}


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type):
        if issubclass(annotation, BaseModel):
            yield annotation
        return
    for part in get_args(annotation):
        yield from _models(part)


def parse(texts: Sequence[str]) -> dict[str, list[str]]:
    """`field=kind,kind` of every text. Raises CompareError."""
    vary: dict[str, list[str]] = {}
    for text in texts:
        field, equals, rest = text.partition("=")
        if not equals or not all(rest.split(",")):
            raise CompareError(f"--vary {text}: write it as FIELD=kind,kind, such as majorant=global,grid")
        if field in vary:
            raise CompareError(f"--vary {text}: {field} varies already; name all of its kinds at once")
        vary[field] = rest.split(",")
    return vary


def variants(scene: Scene, vary: Mapping[str, Sequence[str]]) -> list[Variant]:
    """A variant of the scene for every combination of choices. Raises CompareError.

    A field that is of the chosen kind already keeps its numbers; else they are that kind's defaults.
    """
    for field, chosen in vary.items():
        if field not in FIELDS:
            raise CompareError(f"{field} cannot vary; what can is {', '.join(FIELDS)}")
        known = kinds(field)
        for kind in chosen:
            if kind not in known:
                raise CompareError(f"{field} has no kind {kind}; it has {', '.join(known)}")
            if list(chosen).count(kind) > 1:
                raise CompareError(f"{field} names {kind} twice")
    count = prod(len(chosen) for chosen in vary.values())
    if not 2 <= count <= MOST_VARIANTS:
        raise CompareError(f"a comparison takes 2 to {MOST_VARIANTS} variants, not {count}")
    return [_variant(scene, dict(zip(vary, chosen, strict=True)), vary) for chosen in product(*vary.values())]


def seeded(variants: Sequence[Variant], first: int, taken: int | None) -> list[Variant]:
    """The variants with a seed each, from `first` on: their errors are independent. taken: what none may have."""
    seeds = (seed for k in count() if (seed := (first + k) % (1 << 32)) != taken)
    return [
        replace(variant, scene=variant.scene.model_copy(update={"seed": seed}))
        for variant, seed in zip(variants, seeds, strict=False)
    ]


def _variant(scene: Scene, choices: dict[str, str], vary: Mapping[str, Sequence[str]]) -> Variant:
    own = {field: getattr(scene, field) for field in choices}
    changed = {field: {"kind": kind} for field, kind in choices.items() if getattr(own[field], "kind", None) != kind}
    label = ", ".join(kind for field, kind in choices.items() if len(vary[field]) > 1)
    try:
        return Variant(label, choices, Scene.model_validate(scene.model_dump() | changed))
    except ValidationError as error:
        raise CompareError(f"{label}: {explain(error.errors(include_url=False))}") from None
