// Uploaded files into the scene: at the cursor, where that is in something that names one of the kind, or as a part of
// its own.

import { fields, items, kindOf, nodeAt, pathTo, sceneNode, treeOf } from "./place.js";
import { written } from "./written.js";

const PARTS = {
  volume: { list: "volumes", part: (file) => ({ kind: "grid", ...file, albedo: 0.9 }) },
  mesh: { list: "surfaces", part: (file) => ({ kind: "mesh", ...file, material: { kind: "diffuse", reflectance: 0.5 } }) },
  picture: { list: "lights", part: (file) => ({ kind: "image", ...file }) },
};
const NEEDED = { mesh: "mesh", image: "picture" }; // by the kind of what names a file; else a volume

// grid: the one that is meant, and the scale that shows it, for volumes: {grid, scale}
export function use(view, schema, { id, type }, more = {}) {
  const { state } = view;
  const there = holderAtCursor(state, schema, type);
  const changes = there ? filling(state, there, id, more.grid) : adding(state, PARTS[type], { file: id, ...more });
  view.dispatch({ changes, userEvent: "input.file", scrollIntoView: true });
  view.focus();
}

// The object around the cursor that may name a file of this type.
function holderAtCursor(state, schema, type) {
  for (let node = treeOf(state).resolveInner(state.selection.main.head, -1); node; node = node.parent) {
    if (node.name !== "Object") continue;
    const kind = kindOf(state, node);
    const { steps, kinds } = pathTo(state, node);
    const place = schema.at(steps, kinds);
    const [choice] = place ? schema.objects(place, kind) : [];
    if (choice?.properties.file && (NEEDED[kind] ?? "volume") === type) return node;
  }
  return null;
}

function filling(state, holder, id, grid) {
  const there = fields(state, holder);
  return [["file", id], ["grid", grid]].flatMap(([key, value]) => {
    if (value === undefined) return [];
    const node = there.get(key);
    if (node) return [{ from: node.from, to: node.to, insert: JSON.stringify(value) }];
    return [{ from: holder.from + 1, insert: `"${key}": ${JSON.stringify(value)}${there.size > 0 ? ", " : ""}` }];
  });
}

function adding(state, { list, part }, file) {
  const text = written(part(file), "    ");
  const { value, whole } = nodeAt(state, [list]);
  if (whole && value?.name === "Array") {
    const last = items(value).at(-1);
    return last ? { from: last.to, insert: `,\n    ${text}` } : { from: value.from, to: value.to, insert: `[\n    ${text}\n  ]` };
  }
  const scene = sceneNode(state);
  const entry = `\n  "${list}": [\n    ${text}\n  ]`;
  if (scene?.name !== "Object") return { from: state.doc.length, insert: `{${entry}\n}` };
  return { from: scene.from + 1, insert: `${entry}${fields(state, scene).size > 0 ? "," : "\n"}` };
}

// A scene in which files go by their ids, from their names.
export function withFiles(value, ids) {
  if (Array.isArray(value)) return value.map((item) => withFiles(item, ids));
  if (value === null || typeof value !== "object") return value;
  const entries = Object.entries(value).map(([key, item]) => [key, key === "file" ? ids[item] ?? item : withFiles(item, ids)]);
  return Object.fromEntries(entries);
}
