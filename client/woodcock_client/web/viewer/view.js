// A view of a picture: what of it is shown, where and how. It is told in the address, so that it can be shared.

import { MAPS } from "./colours.js";
import { CURVES } from "./curves.js";

// layer: its name; channel: one of its channels, "" for all together.
// exposure: in stops, null for that which brings the picture's 99th percentile to white, as previews have it.
// curve: of CURVES. map: of MAPS for false colour, "none" for tones, null for what fits the layer.
// log: whether false colours are by the logarithm, null for what fits; range: [low, high] of false colours, null for
// what fits. flag: whether NaN and infinities are highlighted.
// zoom: pixels of the screen for one of the picture, null to fit all of it, "crop" to fit the crop; x, y: what of the
// picture is in the middle, null for its middle.
// panorama: whether spherical pictures are looked at from their inside, null for yes; yaw, pitch, fov: radians, to the right
// of the picture's middle, upwards, and the vertical field of view. crop: {x, y, width, height} in pixels.
export const VIEW = {
  layer: "beauty",
  channel: "",
  exposure: null,
  curve: "soft",
  map: null,
  log: null,
  range: null,
  flag: true,
  zoom: null,
  x: null,
  y: null,
  panorama: null,
  yaw: 0,
  pitch: 0,
  fov: (75 * Math.PI) / 180,
  crop: null,
  histogram: false,
  values: false,
};

const DEGREE = Math.PI / 180;

// Six digits are more than a pixel of any screen.
const brief = (number) => String(Number(number.toPrecision(6)));

const words = (known) => ({ read: (text) => (known(text) ? text : undefined), write: (value) => value });
const numbers = (many, known = () => true) => ({
  read(text) {
    const found = text.split(",").map((each) => (each.trim() === "" ? NaN : Number(each)));
    return found.length === many && found.every(Number.isFinite) && known(found) ? found : undefined;
  },
  write: (values) => values.map(brief).join(","),
});
const number = (known) => {
  const one = numbers(1, ([value]) => known(value));
  return { read: (text) => one.read(text)?.[0], write: brief };
};
const flag = { read: (text) => ({ 0: false, 1: true })[text], write: (value) => (value ? "1" : "0") };
const degrees = (known) => {
  const one = number((value) => known(value));
  return { read: (text) => toRadians(one.read(text)), write: (value) => brief(value / DEGREE) };
};
const toRadians = (value) => (value === undefined ? undefined : value * DEGREE);

export const ZOOMS = { least: 1 / 64, most: 64 };
export const FIELDS = { least: 10 * DEGREE, most: 140 * DEGREE };

// How each part of a view is told in the address.
const PARTS = {
  layer: words((text) => /^[\w.]{1,100}$/.test(text)),
  channel: words((text) => /^\w{1,10}$/.test(text)),
  exposure: number((value) => Math.abs(value) <= 200),
  curve: words((text) => Object.hasOwn(CURVES, text)),
  map: words((text) => text === "none" || Object.hasOwn(MAPS, text)),
  log: flag,
  range: numbers(2, ([low, high]) => low < high),
  flag,
  zoom: {
    read: (text) => (text === "fit" ? null : text === "crop" ? text : number((value) => value >= ZOOMS.least && value <= ZOOMS.most).read(text)),
    write: (value) => (value === null ? "fit" : value === "crop" ? value : brief(value)),
  },
  x: number(() => true),
  y: number(() => true),
  panorama: flag,
  yaw: degrees(() => true),
  pitch: degrees((value) => Math.abs(value) <= 90),
  fov: degrees((value) => value * DEGREE >= FIELDS.least && value * DEGREE <= FIELDS.most),
  crop: {
    read(text) {
      const found = numbers(4, ([x, y, width, height]) => x >= 0 && y >= 0 && width >= 1 && height >= 1).read(text);
      if (!found?.every(Number.isInteger)) return undefined;
      const [x, y, width, height] = found;
      return { x, y, width, height };
    },
    write: ({ x, y, width, height }) => [x, y, width, height].join(","),
  },
  histogram: flag,
  values: flag,
};

// The view that an address tells; what it does not tell, or tells wrongly, is as it is at first. query: URLSearchParams
export function readView(query) {
  const told = Object.entries(PARTS).map(([name, { read }]) => [name, query.has(name) ? read(query.get(name)) : undefined]);
  const view = { ...VIEW, ...Object.fromEntries(told.filter(([, value]) => value !== undefined)) };
  return view.crop && !query.has("zoom") ? { ...view, zoom: "crop" } : view;
}

// The same query with the view told in it; other parts stay.
export function writeView(view, query) {
  const told = new URLSearchParams(query);
  const first = view.crop ? { ...VIEW, zoom: "crop" } : VIEW;
  for (const [name, { write }] of Object.entries(PARTS)) {
    if (view[name] === first[name]) told.delete(name);
    else told.set(name, write(view[name]));
  }
  return told;
}
