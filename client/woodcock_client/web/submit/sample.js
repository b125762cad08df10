// A value to begin with for each place of a scene, as a snippet whose fields Tab goes through.

// Where the least that is allowed would not do, alone or beside the others.
const SENSIBLE = {
  origin: [0, 0, 5],
  direction: [0, -1, 0],
  position: [0, 3, 0],
  min: [-1, -1, -1],
  max: [1, 1, 1],
  cosine: [-1, 1],
  value: [1, 1],
  sigma_t: 1,
  albedo: 0.9,
  g: 0.5,
  radiance: 1,
  irradiance: 3,
  intensity: 10,
  epsilon: 1,
  kelvin: 2000,
  diameter: 10,
  samples: 64,
  seconds: 30,
  relative_error: 0.01,
};
const WIDTH = 80; // characters

export class Samples {
  constructor(schema) {
    this.schema = schema;
  }

  // Of a field by its name.
  ofField(property, name) {
    return snippet((mark) => this.#field(property, name, mark));
  }

  // Of one of the choices that a field has.
  ofChoice(choice, name) {
    return snippet((mark) => this.#value(choice, name, mark));
  }

  #field(property, name, mark) {
    const usual = property.default;
    if (usual !== undefined && usual !== null && typeof usual !== "object") return mark(JSON.stringify(usual));
    return this.#value(this.schema.choices(property)[0] ?? {}, name, mark);
  }

  #value(choice, name, mark) {
    if (choice.properties) return this.#object(choice, mark);
    if (choice.enum) return `"${mark(choice.enum[0])}"`;
    const known = SENSIBLE[name];
    if (Array.isArray(known)) return `[${known.map(mark).join(", ")}]`;
    if (choice.prefixItems) return `[${choice.prefixItems.map((item) => this.#field(item, name, mark)).join(", ")}]`;
    if (choice.type === "array") return `[${mark("")}]`;
    if (choice.type === "string") return `"${mark("")}"`;
    return mark(String(known ?? least(choice)));
  }

  #object({ properties, required = [] }, mark) {
    const kind = properties.kind?.const;
    const needed = required.filter((name) => name !== "kind");
    const parts = needed.map((name) => `${JSON.stringify(name)}: ${this.#field(properties[name], name, mark)}`);
    if (kind) parts.unshift(`"kind": ${JSON.stringify(kind)}`);
    const line = `{${parts.join(", ")}}`;
    if (line.replace(/\$\{\d+:(.*?)\}/g, "$1").length <= WIDTH) return line;
    return `{\n${parts.map((part) => `\t${part.replaceAll("\n", "\n\t")}`).join(",\n")}\n}`;
  }
}

// make: is given what marks a field
function snippet(make) {
  let fields = 0;
  return make((text) => `\${${++fields}:${text}}`);
}

const least = ({ type, minimum, exclusiveMinimum }) =>
  type === "boolean" ? false : exclusiveMinimum !== undefined ? exclusiveMinimum + 1 : Math.max(minimum ?? 0, 0);
