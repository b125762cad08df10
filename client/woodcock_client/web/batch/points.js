// Where in a sweep jobs are, and how axes and values are called.

import { brief } from "../format.js";

const LONG = 48; // characters of a value that are shown

const key = (values) => JSON.stringify(values);

// The newest job at each point, by the indices of its values: what was tried again or extended comes later.
export function placed(axes, jobs) {
  const rows = axes.map(({ rows }) => new Map(rows.map((row, index) => [key(row), index])));
  const at = (job) => axes.map(({ paths }, axis) => rows[axis].get(key(paths.map((path) => job.point[path]))));
  return new Map(jobs.map((job) => [at(job).join(), job]));
}

export const called = ({ paths }) => paths.join(", ");

const shown = (value) => {
  const text = typeof value === "string" ? value : (value?.kind ?? JSON.stringify(value));
  const short = brief(text);
  return short.length > LONG ? `${short.slice(0, LONG)}…` : short;
};

export const valued = (row) => row.map(shown).join(", ");

export const pointed = (point) => Object.entries(point).map(([path, value]) => `${path} = ${shown(value)}`).join(", ");
