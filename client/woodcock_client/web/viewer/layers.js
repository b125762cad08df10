// A job's layers, as the canvas takes them.

import { getLayer, getLayers } from "../api.js";

// {width, height, samples, layers: [{name, channels, unit, link}]}
export const loadLayers = (job, signal) => getLayers(job.links.layers, signal);

// One of them: {name, unit, kind, width, height, samples, channels: names, values: Uint16Array of halves, scale}. kind:
// "light", "vector" or "quantity". samples: of an ended job, whose layers a browser may then keep.
export async function loadLayer({ width, height }, layer, { samples, signal }) {
  const { name, unit, channels, link } = layer;
  const query = samples === undefined ? "" : `?samples=${samples}`;
  const { body, headers } = await getLayer(`${link}${query}`, signal);
  return {
    ...{ name, unit, channels, width, height, kind: kindOf(layer) },
    values: new Uint16Array(body), // browsers' machines are little-endian, as the service's answer is
    scale: Number(headers.get("Woodcock-Scale")),
    samples: Number(headers.get("Woodcock-Samples")),
  };
}

function kindOf({ name, unit, channels }) {
  if (channels.join("") === "XYZ") return "vector";
  return unit === "radiance" || name === "albedo" ? "light" : "quantity";
}

const TITLES = {
  beauty: "Beauty",
  denoised: "Denoised",
  variance: "Variance",
  bound: "Error bound",
  samples: "Samples",
  albedo: "Albedo",
  normal: "Normal",
  depth: "Depth",
  optical_depth: "Optical depth",
  transmittance: "Transmittance",
  position: "Position",
};

export function titleOf(name) {
  const [, of, order] = name.match(/^(variance\.)?order\.(\w+)$/) ?? [];
  if (order === undefined) return TITLES[name] ?? name;
  const part = order === "rest" ? "higher orders" : `order ${order}`;
  return of ? `Variance of ${part}` : part.replace(/^./, (first) => first.toUpperCase());
}

const UNITS = {
  radiance: "in the scene’s unit of radiance",
  "radiance²": "in the square of the scene’s unit of radiance",
  length: "in the scene’s unit of length",
  samples: "samples",
};

export const unitOf = (unit) => UNITS[unit] ?? "";
