// The scene's JSON Schema, as the API states it: what may stand where, and how that is said in words.

export class Schema {
  // schemas: of the API, by name
  constructor(schemas) {
    this.schemas = schemas;
    this.scene = schemas.JobCreate.properties.scene;
  }

  // The schemas of which a value meets one; without null, and without references.
  choices(schema) {
    if (schema.$ref) return this.choices(this.schemas[schema.$ref.split("/").at(-1)]);
    const several = schema.oneOf ?? schema.anyOf;
    if (several) return several.flatMap((one) => this.choices(one));
    return schema.type === "null" ? [] : [schema];
  }

  // Those of objects; of the kind that is written, if there is one of it.
  objects(schema, kind) {
    const all = this.choices(schema).filter((choice) => choice.properties);
    const meant = all.filter((choice) => choice.properties.kind?.const === kind);
    return meant.length > 0 ? meant : all;
  }

  // Of what stands at the end of a path (keys and positions); null where nothing may. kinds: of the objects along it.
  at(steps, kinds) {
    return steps.reduce((schema, step, depth) => {
      if (!schema) return null;
      if (typeof step === "number") {
        const list = this.choices(schema).find((choice) => choice.type === "array");
        return list?.prefixItems?.[step] ?? list?.items ?? null;
      }
      const holder = this.objects(schema, kinds[depth]).find((choice) => choice.properties[step]);
      return holder?.properties[step] ?? null;
    }, this.scene);
  }

  // A value without what is as it would be by default.
  lean(value, schema = this.scene) {
    if (Array.isArray(value)) {
      const list = this.choices(schema).find((choice) => choice.type === "array");
      return list?.items ? value.map((item) => this.lean(item, list.items)) : value;
    }
    const [choice] = value && typeof value === "object" ? this.objects(schema, value.kind) : [];
    if (!choice) return value;
    const entries = Object.entries(value)
      .map(([key, item]) => [key, item, choice.properties[key] ?? {}])
      .filter(([key, item, { default: usual }]) => key === "kind" || !same(item, usual))
      .map(([key, item, property]) => [key, this.lean(item, property)]);
    entries.sort(([a], [b]) => (b === "kind") - (a === "kind"));
    return Object.fromEntries(entries);
  }

  // What a value may be, in words: `a number from 0 to 1, or a list of 3`.
  words(schema) {
    const said = this.choices(schema).map((choice) => {
      if (choice.enum) return `one of ${choice.enum.map((one) => JSON.stringify(one)).join(", ")}`;
      if (choice.properties) return choice.properties.kind?.const ?? "an object";
      if (choice.type === "array") return choice.prefixItems ? `a list of ${choice.prefixItems.length}` : "a list";
      return `${TYPES[choice.type] ?? choice.type}${bounds(choice)}`;
    });
    return [...new Set(said)].join(" or ");
  }
}

const TYPES = { number: "a number", integer: "a whole number", string: "a text", boolean: "true or false" };

const same = (a, b) => b !== undefined && JSON.stringify(a) === JSON.stringify(b);

function bounds({ minimum, maximum, exclusiveMinimum, exclusiveMaximum }) {
  if (minimum !== undefined && maximum !== undefined) return ` from ${minimum} to ${maximum}`;
  const said = [];
  if (minimum !== undefined) said.push(`${minimum} or more`);
  if (exclusiveMinimum !== undefined) said.push(`above ${exclusiveMinimum}`);
  if (maximum !== undefined) said.push(`${maximum} or less`);
  if (exclusiveMaximum !== undefined) said.push(`below ${exclusiveMaximum}`);
  return said.length > 0 ? ` ${said.join(" and ")}` : "";
}
