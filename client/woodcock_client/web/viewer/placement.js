// Where a picture lies on the canvas, and how that changes. Lengths are pixels of the screen or, where it is said, of the
// picture.

import { FIELDS, ZOOMS } from "./view.js";

const MARGIN = 0.9; // of the canvas that a crop may take
const MOST_DIRECTIONS = 6;

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// canvas: {width, height}; data: {width, height} of the picture.
export function place(view, data, canvas) {
  if (view.inside) {
    const tangent = Math.tan(view.fov / 2);
    const across = (2 * tangent) / canvas.height / ((2 * Math.PI) / data.width); // picture's pixels for one of the canvas
    const many = clamp(Math.ceil(across), 2, MOST_DIRECTIONS);
    return { panorama: true, yaw: view.yaw, pitch: view.pitch, tangent, many, zoom: 1, left: 0, top: 0 };
  }
  const fit = Math.min(canvas.width / data.width, canvas.height / data.height);
  let { zoom, x, y } = view;
  if (zoom === "crop" && view.crop) {
    const { crop } = view;
    zoom = clamp(MARGIN * Math.min(canvas.width / crop.width, canvas.height / crop.height), Math.min(fit, 1), ZOOMS.most);
    x ??= crop.x + crop.width / 2;
    y ??= crop.y + crop.height / 2;
  }
  if (typeof zoom !== "number") zoom = fit;
  x = clamp(x ?? data.width / 2, 0, data.width);
  y = clamp(y ?? data.height / 2, 0, data.height);
  // Whole pixels: at whole zooms the picture's are as large as each other, and sharp.
  const left = Math.floor(canvas.width / 2 - x * zoom);
  const top = Math.floor(canvas.height / 2 - y * zoom);
  return { panorama: false, yaw: 0, pitch: 0, tangent: 1, many: 1, zoom, left, top, x, y, fit };
}

// The picture's pixel under a point of the canvas, null outside of the picture.
export function pixelAt(placed, data, canvas, point) {
  const at = placed.panorama ? directionAt(placed, data, canvas, point) : { x: (point.x - placed.left) / placed.zoom, y: (point.y - placed.top) / placed.zoom };
  const x = Math.floor(at.x);
  const y = Math.floor(at.y);
  return x >= 0 && y >= 0 && x < data.width && y < data.height ? { x, y } : null;
}

// As `seen` in shaders.js.
function directionAt({ yaw, pitch, tangent }, data, canvas, point) {
  const across = ((2 * point.x - canvas.width) / canvas.height) * tangent;
  const up = -((2 * point.y - canvas.height) / canvas.height) * tangent;
  const risen = up * Math.cos(pitch) + Math.sin(pitch);
  const ahead = Math.cos(pitch) - up * Math.sin(pitch);
  const longitude = Math.atan2(across, ahead) + yaw;
  const latitude = Math.atan2(risen, Math.hypot(across, ahead));
  const turn = longitude / (2 * Math.PI) + 0.5;
  return {
    x: (turn - Math.floor(turn)) * data.width,
    y: Math.min((0.5 - latitude / Math.PI) * data.height, data.height - 1e-6),
  };
}

// The view after the picture was moved by so many pixels of the canvas.
export function panned(view, data, canvas, dx, dy) {
  const placed = place(view, data, canvas);
  if (placed.panorama) {
    const angle = (2 * placed.tangent) / canvas.height; // of a pixel in the middle
    const yaw = Math.atan2(Math.sin(view.yaw - dx * angle), Math.cos(view.yaw - dx * angle));
    return { ...view, yaw, pitch: clamp(view.pitch + dy * angle, -Math.PI / 2, Math.PI / 2) };
  }
  const { zoom } = placed;
  const x = clamp(placed.x - dx / zoom, 0, data.width);
  const y = clamp(placed.y - dy / zoom, 0, data.height);
  return { ...view, zoom, x, y };
}

// The view so many times as large, with what is at a point of the canvas staying there.
export function zoomed(view, data, canvas, factor, point = { x: canvas.width / 2, y: canvas.height / 2 }) {
  const placed = place(view, data, canvas);
  if (placed.panorama) return { ...view, fov: clamp(view.fov / factor, FIELDS.least, FIELDS.most) };
  const zoom = clamp(placed.zoom * factor, Math.min(placed.fit, 1 / 16), ZOOMS.most);
  const middle = { x: canvas.width / 2, y: canvas.height / 2 };
  const x = placed.x + ((point.x - middle.x) / placed.zoom) * (1 - placed.zoom / zoom);
  const y = placed.y + ((point.y - middle.y) / placed.zoom) * (1 - placed.zoom / zoom);
  return { ...view, zoom, x: clamp(x, 0, data.width), y: clamp(y, 0, data.height) };
}

// All of the picture; of a panorama, its middle.
export const fitted = (view) =>
  view.inside ? { ...view, yaw: 0, pitch: 0 } : { ...view, zoom: null, x: null, y: null };

// One pixel of the screen for each of the picture.
export function oneToOne(view, data, canvas) {
  const { panorama, x, y } = place(view, data, canvas);
  return panorama ? view : { ...view, zoom: 1, x, y };
}
