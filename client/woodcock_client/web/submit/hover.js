// What a field of the scene is, in words, where the pointer rests.

import { hoverTooltip } from "@codemirror/view";
import { pathTo, treeOf } from "./place.js";

const PLACES = new Set(["PropertyName", "String", "Number", "True", "False", "Null"]);

export const hover = (schema) =>
  hoverTooltip((view, pos, side) => {
    const node = treeOf(view.state).resolveInner(pos, side);
    if (!PLACES.has(node.name)) return null;
    const { steps, kinds } = pathTo(view.state, node);
    const name = steps.findLast((step) => typeof step === "string");
    const depth = steps.lastIndexOf(name);
    const place = name === undefined ? null : schema.at(steps.slice(0, depth + 1), kinds);
    if (!place) return null;
    const [kind] = name === "kind" ? schema.objects(schema.at(steps.slice(0, depth), kinds), kinds[depth]) : [];
    const lines = [(kind ?? place).description, kind ? null : ask(schema, place)];
    return { pos: node.from, end: node.to, above: true, create: () => ({ dom: note(kind?.properties.kind.const ?? name, lines) }) };
  });

function ask(schema, place) {
  const usual = place.default ?? undefined;
  const words = schema.words(place);
  return usual === undefined ? words : `${words}; by default ${JSON.stringify(usual)}`;
}

function note(name, lines) {
  const dom = document.createElement("div");
  dom.className = "note";
  for (const [tag, text] of [["strong", name], ...lines.map((line) => ["p", line])]) {
    if (text) dom.appendChild(document.createElement(tag)).textContent = text;
  }
  return dom;
}
