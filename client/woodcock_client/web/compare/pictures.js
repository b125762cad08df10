// The pictures of a comparison and the maps of how they differ, as the canvas takes them.

import { loadLayer, loadLayers } from "../viewer/layers.js";

export async function loadBeauty(job, signal) {
  const { layers } = await loadLayers(job, signal);
  const beauty = layers.find(({ name }) => name === "beauty");
  return loadLayer(job, beauty, { samples: job.samples, signal });
}

// channels: of the two pictures, the more; FLIP has one value for all.
export const loadMap = (job, { maps }, map, channels, signal) =>
  loadLayer(job, { name: map, unit: "", channels: map === "flip" ? ["FLIP"] : channels, link: maps[map] }, { signal });
