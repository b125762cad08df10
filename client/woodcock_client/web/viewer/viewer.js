// The picture of a job: its layers with WebGL2, as it is rendered too; the preview where that cannot be.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { isActive } from "../api.js";
import { samples, title } from "../format.js";
import { html } from "../html.js";
import { Picture } from "../picture.js";
import { exposureShown, mapOf } from "./appearance.js";
import { Canvas } from "./canvas.js";
import { Crop, isInside, middleOf } from "./crop.js";
import { CURVE_NAMES } from "./curves.js";
import { Histogram } from "./histogram.js";
import { Keys, KEYS_ID, onKey, Spoken } from "./keys.js";
import { titleOf } from "./layers.js";
import { Legend } from "./legend.js";
import { useLayers, usePixels } from "./loading.js";
import { place } from "./placement.js";
import { inFalseColour, shownAs, Tools, turned, withLayer } from "./tools.js";
import { Line, samplesAt, Values } from "./values.js";
import { readView, writeView } from "./view.js";

const REFINE = 1500; // ms between two versions of the preview
const SMALL = 320; // pixels; a preview up to this size shows its pixels rather than a blur
const TOLD = 200; // ms until a view that no longer changes is told in the address
const HALF_STOP = 0.5;

export function Viewer({ job, query }) {
  const [told, setView] = useView(query);
  const { list, data, problem } = useLayers(job, told.layer);
  const [fault, setFault] = useState(null);
  const [point, setPoint] = useState(null);
  const [size, setSize] = useState(null);
  const [keys, setKeys] = useState(false);
  const spherical = job.scene.camera.kind === "spherical";
  const view = useMemo(() => fitting(told, data, spherical), [told, data, spherical]);
  const version = data?.samples;
  const pixels = usePixels(job, point, version);
  const cropped = usePixels(job, view.crop, version);
  const shape = { "--width": job.width, "--height": job.height };

  if (fault || !data) {
    const small = Math.max(job.width, job.height) <= SMALL;
    return html`
      <section class="viewer" aria-label="Picture">
        <div class=${`stage large ${small ? "pixels" : ""}`} style=${shape}><${Picture} job=${job} every=${REFINE} /></div>
        <p class="note fact" role="status">${why(fault, problem, job)}</p>
        ${!fault && html`<div class="tools" aria-hidden="true"></div>`}
      </section>
    `;
  }

  const cropping = () => setView({ ...view, crop: view.crop ? null : middleOf(data), zoom: view.zoom === "crop" ? null : view.zoom });
  const commands = {
    e: () => setView({ ...view, exposure: exposureShown(view, data) - HALF_STOP }),
    E: () => setView({ ...view, exposure: exposureShown(view, data) + HALF_STOP }),
    l: () => setView(withLayer(view, beside(list, view, 1))),
    L: () => setView(withLayer(view, beside(list, view, -1))),
    c: () => setView(shownAs(view, data, CURVE_NAMES[(CURVE_NAMES.indexOf(view.curve) + 1) % CURVE_NAMES.length])),
    f: () => setView({ ...view, map: inFalseColour(view, data) ? "none" : "viridis", range: null }),
    h: () => setView({ ...view, histogram: !view.histogram }),
    v: () => setView({ ...view, values: !view.values }),
    n: () => setView({ ...view, flag: !view.flag }),
    p: () => spherical && setView(turned(view)),
    "?": () => setKeys(true),
  };
  return html`
    <section class="viewer" aria-label="Picture" onKeyDown=${(event) => onKey(event, commands)}>
      <div class="stage large" style=${shape}>
        <${Canvas}
          data=${data}
          view=${view}
          onView=${setView}
          onPoint=${setPoint}
          onCrop=${(crop) => setView({ ...view, crop })}
          onSize=${setSize}
          onFault=${setFault}
          label=${`Picture of ${title(job)}: ${titleOf(data.name)}, ${data.width} × ${data.height} pixels`}
          describedBy=${KEYS_ID}
        />
        ${view.values && pixels && html`<div class=${`over top ${away(pixels, view, data, size) ? "right" : ""}`}><${Values} pixels=${pixels} /></div>`}
        <div class="over">
          ${view.histogram && html`<${Histogram} view=${view} data=${data} />`}
          ${mapOf(view, data) !== "none" && html`<${Legend} view=${view} data=${data} />`}
        </div>
      </div>
      <${Spoken} />
      <p class="note fact">
        ${problem && problem.status !== 0 ? problem.message : pixels ? html`<${Readout} pixels=${pixels} layer=${data.name} />` : "Point at the picture for its values, drag to move it, press ? for keys."}
      </p>
      <${Tools} view=${view} onView=${setView} data=${data} list=${list} size=${size} spherical=${spherical} onCrop=${cropping} onKeys=${() => setKeys(true)} />
      ${view.crop && html`<${Crop} view=${view} onView=${setView} data=${data} pixels=${cropped} />`}
      <${Keys} open=${keys} onClose=${() => setKeys(false)} />
    </section>
  `;
}

const Readout = ({ pixels, layer }) => html`
  <span class="at">${`${pixels.x}, ${pixels.y}`}</span> ${titleOf(layer)} <${Line} pixels=${pixels} layer=${layer} /> ${layer !== "samples" && samples(samplesAt(pixels))}
`;

// The view without what the layer or the picture does not have.
function fitting(view, data, spherical) {
  const inside = spherical && (view.panorama ?? true) && view.zoom !== "crop";
  if (!data) return { ...view, inside };
  const channel = data.channels.includes(view.channel) ? view.channel : "";
  const crop = view.crop && isInside(view.crop, data) ? view.crop : null;
  return { ...view, inside, channel, crop };
}

// Whether the pixel is in the left half of the canvas.
const away = ({ x }, view, data, size) => size && !view.inside && x < place(view, data, size).x;

// Layers after the one that is chosen, which may be on its way still.
function beside({ layers }, { layer }, step) {
  const at = Math.max(0, layers.findIndex(({ name }) => name === layer));
  return layers[(at + step + layers.length) % layers.length].name;
}

// Why there is only a preview, if there is one.
function why(fault, problem, job) {
  if (fault) return `${fault} This is the preview.`;
  if (problem && problem.status !== 0) return problem.message;
  if (!job.links.preview) return "";
  if (!isActive(job)) return job.links.layers ? "" : "The preview is all that is left of it.";
  return "This is the preview; what it is made of comes with the first checkpoint.";
}

// The view that the address tells, and a function that changes both.
function useView(query) {
  const address = query.toString();
  const [view, setView] = useState(() => readView(query));
  const first = useRef(address);

  useEffect(() => {
    if (address === first.current) return; // the page came with it
    first.current = address;
    setView(readView(query));
  }, [address]);

  useEffect(() => {
    const timer = setTimeout(() => {
      const { inside, ...rest } = view;
      const found = String(writeView(rest, new URLSearchParams(location.search)));
      if (found !== location.search.replace(/^\?/, "")) history.replaceState(null, "", `${location.pathname}${found && `?${found}`}`);
    }, TOLD);
    return () => clearTimeout(timer);
  }, [view]);

  return [view, setView];
}
