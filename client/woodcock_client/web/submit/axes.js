// What a sweep varies. An axis: {path, how: "list", "linear" or "log"; list: text; from, to, steps: texts; zipped}.

export const AXIS = { path: "", how: "list", list: "", from: "", to: "", steps: "3", zipped: false };

const DIGITS = 6; // of values between two ends

// Paths of the scene's numbers, as a sweep names them.
export function numbersOf(value, path = "") {
  if (typeof value === "number") return [path];
  if (value === null || typeof value !== "object") return [];
  if (Array.isArray(value)) return value.flatMap((item, index) => numbersOf(item, `${path}[${index}]`));
  return Object.entries(value).flatMap(([key, item]) => numbersOf(item, path ? `${path}.${key}` : key));
}

// The values of an axis, or a sentence that says why there are none. whole: of whole numbers
export function valuesOf({ how, list, from, to, steps }, whole) {
  if (how === "list") return listed(list);
  const [low, high, count] = [from, to, steps].map(Number);
  if (from === "" || to === "" || !Number.isFinite(low) || !Number.isFinite(high)) return "needs two numbers";
  if (!Number.isInteger(count) || count < 2 || count > 1000) return "needs from 2 to 1000 steps";
  if (how === "log" && !(low > 0 && high > 0)) return "needs two numbers above 0";
  const at = (t) => (how === "log" ? low * (high / low) ** t : low + (high - low) * t);
  const round = (x) => (whole ? Math.round(x) : Number(x.toPrecision(DIGITS)));
  return [...new Set(Array.from({ length: count }, (_, index) => round(at(index / (count - 1)))))];
}

// JSON where it can be read as that, else text.
function listed(text) {
  if (text.trim() === "") return "needs values, with commas";
  try {
    return JSON.parse(`[${text}]`);
  } catch {
    return text.split(",").map((item) => item.trim());
  }
}

// {product, zip: as the API takes them; count: of renders; fault: a sentence, null if it can be asked for}
export function sweepOf(axes, isWhole) {
  const groups = { product: {}, zip: {} };
  for (const axis of axes) {
    const { path, zipped } = axis;
    const values = valuesOf(axis, isWhole(path));
    if (!path) return { ...groups, count: 0, fault: "A field needs its path, such as volumes[0].sigma_t." };
    if (path in groups.product || path in groups.zip) return { ...groups, count: 0, fault: `${path} is there twice.` };
    if (typeof values === "string") return { ...groups, count: 0, fault: `${path} ${values}.` };
    groups[zipped ? "zip" : "product"][path] = values;
  }
  const lengths = new Set(Object.values(groups.zip).map((values) => values.length));
  const fault = lengths.size > 1 ? "Fields that go together need as many values each." : null;
  const count = Object.values(groups.product).reduce((n, values) => n * values.length, [...lengths][0] ?? 1);
  return { ...groups, count: fault ? 0 : count, fault };
}
