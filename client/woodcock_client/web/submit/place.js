// From places in the text to paths in the scene, and back, by the syntax tree: so they are known in a text with faults.

import { ensureSyntaxTree, syntaxTree } from "@codemirror/language";

const VALUES = new Set(["Object", "Array", "String", "Number", "True", "False", "Null"]);
const PATIENCE = 100; // ms for the tree of a long text

export const treeOf = (state) => ensureSyntaxTree(state, state.doc.length, PATIENCE) ?? syntaxTree(state);

const children = (node, names) => {
  const found = [];
  for (let child = node.firstChild; child; child = child.nextSibling) if (names.has(child.name)) found.push(child);
  return found;
};

export const items = (list) => children(list, VALUES);

const properties = (object) => children(object, new Set(["Property"]));

const valueOf = (property) => children(property, VALUES)[0] ?? null;

const unquoted = (state, { from, to }) => {
  try {
    return JSON.parse(state.sliceDoc(from, to));
  } catch {
    return null;
  }
};

function keyOf(state, property) {
  const name = property.getChild("PropertyName");
  return name && unquoted(state, name);
}

// The keys of an object, and the nodes of their values: null where there is none.
export const fields = (state, object) =>
  new Map(properties(object).map((property) => [keyOf(state, property), valueOf(property)]));

export function textOf(state, node) {
  return node?.name === "String" ? unquoted(state, node) : null;
}

export const kindOf = (state, object) => textOf(state, fields(state, object).get("kind"));

// Keys and positions from the scene to a node, and the kinds of the objects that they lead through.
export function pathTo(state, node) {
  const steps = [];
  const kinds = [];
  for (let child = node; child.parent; child = child.parent) {
    const { parent } = child;
    if (parent.name === "Array") steps.unshift(items(parent).findIndex((item) => item.from === child.from));
    else if (parent.name === "Property") steps.unshift(keyOf(state, parent));
    else continue;
    const holder = parent.name === "Array" ? parent : parent.parent;
    kinds.unshift(holder.name === "Object" ? kindOf(state, holder) : null);
  }
  return { steps, kinds };
}

// `volumes[0].sigma_t` as ["volumes", 0, "sigma_t"].
export const stepsOf = (path) =>
  [...path.matchAll(/\[(\d+)\]|\[("(?:[^"\\]|\\.)*")\]|([^.[\]]+)/g)].map(([, position, quoted, name]) =>
    position !== undefined ? Number(position) : quoted !== undefined ? JSON.parse(quoted) : name,
  );

export const sceneNode = (state) => items(treeOf(state).topNode)[0] ?? null;

// The node at the end of a path, or the last one on the way that there is, with the property that it is the value of.
export function nodeAt(state, steps) {
  let found = { value: sceneNode(state), property: null };
  for (const step of steps) {
    let next;
    if (typeof step === "number" && found.value?.name === "Array") {
      next = { value: items(found.value)[step], property: null };
    } else if (found.value?.name === "Object") {
      const property = properties(found.value).find((one) => keyOf(state, one) === step);
      next = property && { value: valueOf(property), property };
    }
    if (!next || !(next.value || next.property)) return { ...found, whole: false };
    found = next;
  }
  return { ...found, whole: true };
}
