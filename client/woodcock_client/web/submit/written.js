// JSON as people write it: on one line what fits there, else an item a line.

const WIDTH = 100; // characters

const isWhole = (value) => typeof value !== "object" || value === null;

function inOneLine(value) {
  if (isWhole(value)) return JSON.stringify(value);
  if (Array.isArray(value)) return `[${value.map(inOneLine).join(", ")}]`;
  return `{${Object.entries(value).map(([key, item]) => `${JSON.stringify(key)}: ${inOneLine(item)}`).join(", ")}}`;
}

// before: characters on the line in front of it
export function written(value, indent = "", before = 0) {
  const line = inOneLine(value);
  if (isWhole(value) || line.length < 3 || (indent && indent.length + before + line.length < WIDTH)) return line;
  const within = `${indent}  `;
  const items = Array.isArray(value)
    ? value.map((item) => within + written(item, within))
    : Object.entries(value).map(([key, item]) => {
        const name = `${JSON.stringify(key)}: `;
        return within + name + written(item, within, name.length);
      });
  const [open, close] = Array.isArray(value) ? "[]" : "{}";
  return `${open}\n${items.join(",\n")}\n${indent}${close}`;
}
