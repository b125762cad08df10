// What is wrong with a scene, and where in its text that is.

import { nodeAt, stepsOf, treeOf } from "./place.js";

// What keeps a text from being JSON, null if nothing does: {message, from, to}.
export function syntaxFault(state) {
  const text = state.doc.toString();
  try {
    JSON.parse(text);
    return null;
  } catch (error) {
    const at = firstError(state) ?? Number(error.message.match(/position (\d+)/)?.[1] ?? text.length);
    const from = Math.min(at, Math.max(0, text.length - 1));
    return { message: `This is not JSON yet: ${plain(error.message)}.`, from, to: Math.min(from + 1, text.length) };
  }
}

// Of what a browser says, the part without the place, which is marked.
const plain = (message) =>
  message
    .replace(/^JSON\.parse: /, "")
    .replace(/,? (in JSON )?at (position|line) \d.*$/s, "")
    .replace(/, "?\.\.\..*$|, ".*" is not valid JSON$/s, "")
    .replace(/\.$/, "");

function firstError(state) {
  let at = null;
  treeOf(state).iterate({
    enter: (node) => {
      if (at === null && node.type.isError) at = node.from;
    },
  });
  return at;
}

// The place of a field of the scene: the property where it is one, or else what is nearest to it.
export function placeOf(state, field) {
  const { value, property, whole } = nodeAt(state, stepsOf(field).slice(1)); // after `scene`
  const nested = value && ["Object", "Array"].includes(value.name);
  if (property && whole && !nested) return { from: property.from, to: property.to };
  const name = property?.getChild("PropertyName");
  if (name) return { from: name.from, to: name.to };
  if (value) return { from: value.from, to: nested ? value.from + 1 : value.to };
  return { from: 0, to: Math.min(1, state.doc.length) };
}

export const isOfScene = ({ field }) => /^scene($|[.[])/.test(field);

// As the editor marks them.
export const diagnostics = (state, faults) =>
  faults.filter(isOfScene).map((fault) => ({
    ...placeOf(state, fault.field),
    severity: "error",
    message: `${fault.field.replace(/^scene\.?/, "") || "scene"}: ${fault.message}`,
  }));
