// What may stand at the cursor: keys that are allowed there, kinds, values of lists, and files that were uploaded.

import { insertCompletionText, pickedCompletion, snippet } from "@codemirror/autocomplete";
import { fields, items, kindOf, pathTo, textOf, treeOf } from "./place.js";
import { Samples } from "./sample.js";

// schema: a Schema; files: () => the uploaded files
export function completion(schema, files) {
  const samples = new Samples(schema);
  return (context) => {
    const place = placeAt(context.state, context.pos);
    if (!place || (!context.explicit && !place.begun)) return null;
    const options = place.property ? keys(schema, samples, context.state, place) : values(schema, samples, files(), context.state, place);
    if (options.length === 0) return null;
    return { from: place.from, options: place.quoted ? options.map(overQuoted) : options, validFor: /^"?[\w.-]*$/ };
  };
}

// An option in place of all that is between quotes, not only of what is before the cursor.
function overQuoted(option) {
  const { apply = option.label } = option;
  const put = (view, chosen, from, to) => {
    const end = to + (view.state.sliceDoc(to).match(/^[^"\n]*"/)?.[0].length ?? 0);
    if (typeof apply === "function") return apply(view, chosen, from, end);
    const text = insertCompletionText(view.state, apply, from, end);
    return view.dispatch({ ...text, annotations: pickedCompletion.of(chosen) });
  };
  return { ...option, apply: put };
}

// Where a word at the cursor begins and ends, in which object or list it is, and whether it is a key (`property`) or
// else the value of the field `name`, or the item at `position`. begun: something was typed there; quoted: in quotes.
function placeAt(state, cursor) {
  const inner = treeOf(state).resolveInner(cursor, -1);
  const quoted = ["String", "PropertyName"].includes(inner.name) && inner.from < cursor && cursor < inner.to;
  const before = state.sliceDoc(0, cursor);
  const from = quoted ? inner.from : cursor - before.match(/[\w.+-]*$/)[0].length;
  const to = quoted ? inner.to : cursor;
  const holder = holderOf(treeOf(state).resolveInner(from, -1), from);
  if (!holder) return null;
  const lead = before.slice(0, from).trimEnd();
  const place = { from, to, holder, quoted, begun: from < cursor };
  const named = lead.match(/"([^"\\]*)"\s*:$/); // no field's name has an escape
  if (named) return { ...place, name: named[1] };
  if (holder.name === "Object") return /[{,]$/.test(lead) ? { ...place, property: true } : null;
  return /[[,]$/.test(lead) ? { ...place, position: items(holder).filter((item) => item.to <= from).length } : null;
}

// The innermost object or list that a place is in; one that is not closed yet goes on.
function holderOf(node, at) {
  const open = (one) => one.to > at || !/[\]}]/.test(one.lastChild?.name ?? "");
  while (node && !(["Object", "Array"].includes(node.name) && node.from < at && open(node))) node = node.parent;
  return node;
}

function keys(schema, samples, state, { holder, from, to }) {
  const { steps, kinds } = pathTo(state, holder);
  const place = schema.at(steps, kinds);
  const there = fields(state, holder);
  const kind = kindOf(state, holder);
  const choices = place ? schema.objects(place, kind) : [];
  const alone = choices.length === 1; // else what it is made of follows from its kind
  const rest = state.sliceDoc(to);
  const comma = /^\s*"/.test(rest) ? "," : "";
  const required = choices[0]?.required ?? [];
  return Object.entries(choices[0]?.properties ?? {})
    .filter(([key]) => (alone || key === "kind") && (!there.has(key) || within(state, from, key)))
    .map(([key, property]) => ({
      label: JSON.stringify(key),
      displayLabel: key,
      type: "property",
      detail: required.includes(key) ? "required" : schema.words(property),
      info: property.description,
      boost: required.includes(key) ? 1 : 0,
      apply: /^\s*:/.test(rest)
        ? JSON.stringify(key)
        : snippet(`${JSON.stringify(key)}: ${key === "kind" && !alone ? '"${1:}"' : samples.ofField(property, key)}${comma}`),
    }));
}

// Is that the key at the cursor itself?
const within = (state, from, key) => state.sliceDoc(from, from + key.length + 2) === JSON.stringify(key);

function values(schema, samples, files, state, { holder, name, position }) {
  const { steps, kinds } = pathTo(state, holder);
  const around = schema.at(steps, kinds);
  if (!around) return [];
  if (name === "kind") return kindsOf(schema, around);
  const own = holder.name === "Object" ? kindOf(state, holder) : null;
  const place = schema.at([...steps, name ?? position], [...kinds, own]);
  if (!place) return [];
  if (name === "file") return fileOptions(files);
  if (name === "grid") return gridOptions(files, textOf(state, fields(state, holder).get("file")));
  return schema.choices(place).flatMap((choice) => valueOptions(samples, choice, place, name));
}

const kindsOf = (schema, place) =>
  schema.objects(place, undefined).map((choice) => ({
    label: JSON.stringify(choice.properties.kind?.const),
    displayLabel: choice.properties.kind?.const,
    type: "enum",
    info: choice.description,
  }));

function valueOptions(samples, choice, place, name) {
  if (choice.properties) {
    const label = choice.properties.kind?.const ?? name;
    const apply = snippet(samples.ofChoice(choice, name));
    return [{ label: JSON.stringify(label), displayLabel: label, type: "class", detail: "object", info: choice.description, apply }];
  }
  if (choice.enum) return choice.enum.map((one) => ({ label: JSON.stringify(one), displayLabel: one, type: "enum" }));
  if (choice.type === "boolean") return ["true", "false"].map((label) => ({ label, type: "keyword" }));
  if (choice.type === "array") {
    const text = samples.ofChoice(choice, name);
    return [{ label: text.replace(/\$\{\d+:(.*?)\}/g, "$1"), type: "constant", apply: snippet(text) }];
  }
  const usual = place.default;
  return typeof usual === "number" ? [{ label: String(usual), type: "constant", detail: "default" }] : [];
}

const fileOptions = (files) =>
  files.map((file) => ({
    label: JSON.stringify(file.name),
    displayLabel: file.name,
    type: "text",
    detail: file.type,
    apply: JSON.stringify(file.id),
  }));

const gridOptions = (files, id) =>
  (files.find((file) => file.id === id)?.grids ?? []).map((grid) => ({
    label: JSON.stringify(grid.name),
    displayLabel: grid.name,
    type: "text",
    detail: `${grid.type}, ${grid.shape.join(" × ")}`,
  }));
