// A picture of half floats on a canvas, with a view of it that can be moved.
//
// data: {width, height, channels: names of one or three, values: Uint16Array of halves, scale}, and, as layers.js has them,
// kind and unit. view: view.js, and `inside` for a panorama. onView(view) after it was moved or made larger;
// onPoint({x, y} or null): the picture's pixel under the pointer or, with keys, in the middle; onCrop({x, y, width, height})
// if a rectangle may be chosen; onSize({width, height, ratio}) of the canvas, as placement.js wants it; onFault(sentence)
// where nothing can be drawn. label: what the picture is, in words; describedBy: the id of what says its keys.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { html } from "../html.js";
import { looks } from "./appearance.js";
import { listen } from "./gestures.js";
import { Fault, Screen } from "./gl.js";
import { fitted, oneToOne, panned, pixelAt, place, zoomed } from "./placement.js";

const PATIENCE = 4000; // ms for a lost context to come back
const MARKED = 6; // pixels of the page for one of the picture from which on the one under the pointer is marked

export function Canvas({ data, view, onView, onPoint, onCrop, onSize, onFault, label, describedBy }) {
  const canvas = useRef();
  const screen = useRef(null);
  const now = useRef();
  const [size, setSize] = useState(null); // {width, height} of the canvas and `ratio`: its pixels for one of the page
  const [point, setPoint] = useState(null); // of the picture
  const [chosen, setChosen] = useState(null); // what is being chosen
  const [drawable, setDrawable] = useState(0); // how often a context came
  const pointed = useRef(null); // of the canvas
  const told = useRef(null); // of the picture
  now.current = { data, view, size, onView, onPoint, onCrop, onSize, onFault };

  function see(at) {
    pointed.current = at;
    const { data, view, size } = now.current;
    const found = at && pixelAt(place(view, data, size), data, size, at);
    if (found?.x === told.current?.x && found?.y === told.current?.y) return;
    told.current = found;
    setPoint(found);
    now.current.onPoint?.(found);
  }

  useEffect(() => {
    const element = canvas.current;
    let timer;
    const fail = (sentence) => now.current.onFault?.(sentence);
    const open = (how) => {
      try {
        how();
        setDrawable((times) => times + 1);
      } catch (error) {
        if (!(error instanceof Fault)) throw error;
        fail(error.message);
      }
    };
    const lost = (event) => {
      event.preventDefault(); // so that it may come back
      timer = setTimeout(() => fail("The graphics card was taken away from this page."), PATIENCE);
    };
    const restored = () => {
      clearTimeout(timer);
      open(() => screen.current.restore());
    };
    open(() => (screen.current = new Screen(element)));
    element.addEventListener("webglcontextlost", lost);
    element.addEventListener("webglcontextrestored", restored);
    return () => {
      clearTimeout(timer);
      element.removeEventListener("webglcontextlost", lost);
      element.removeEventListener("webglcontextrestored", restored);
      screen.current?.close();
    };
  }, []);

  useLayoutEffect(() => {
    const observer = new ResizeObserver(([{ contentRect: { width, height } }]) => {
      const ratio = devicePixelRatio;
      const found = { width: Math.max(1, Math.round(width * ratio)), height: Math.max(1, Math.round(height * ratio)), ratio };
      setSize(found);
      now.current.onSize?.(found);
    });
    observer.observe(canvas.current);
    return () => observer.disconnect();
  }, []);

  useEffect(() => {
    const scaled = ({ x, y }) => ({ x: x * now.current.size.ratio, y: y * now.current.size.ratio });
    const show = (view) => {
      now.current.view = view; // several may come before it is drawn
      now.current.onView(view);
    };
    return listen(canvas.current, {
      onMove(dx, dy) {
        const { view, data, size } = now.current;
        show(panned(view, data, size, dx * size.ratio, dy * size.ratio));
      },
      onZoom(factor, at) {
        const { view, data, size } = now.current;
        show(zoomed(view, data, size, factor, at && scaled(at)));
      },
      onPoint: (at) => see(at && scaled(at)),
      onMiddle: () => see({ x: now.current.size.width / 2, y: now.current.size.height / 2 }),
      onChoose(from, to, done) {
        const { data, view, size, onCrop } = now.current;
        if (!onCrop || view.inside) return;
        const crop = between(scaled(from), scaled(to), place(view, data, size), data);
        setChosen(done ? null : crop);
        if (done && crop) onCrop(crop);
      },
      onFit: () => show(fitted(now.current.view)),
      onOne: () => show(oneToOne(now.current.view, now.current.data, now.current.size)),
    });
  }, []);

  useLayoutEffect(() => {
    if (!size || !drawable) return;
    const { width, height } = size;
    const element = canvas.current;
    if (element.width !== width || element.height !== height) Object.assign(element, { width, height });
    try {
      screen.current.show(data);
      screen.current.draw(looks(view, data), place(view, data, size));
    } catch (error) {
      if (!(error instanceof Fault)) throw error;
      onFault?.(error.message);
    }
    if (pointed.current) see(pointed.current); // another pixel is under a pointer that rests
  }, [data, view, size, drawable]);

  const placed = size && place(view, data, size);
  const frame = chosen ?? view.crop;
  const large = placed && placed.zoom / size.ratio >= MARKED;
  return html`
    <div class="canvas">
      <canvas
        ref=${canvas}
        tabindex="0"
        role="application"
        aria-roledescription="picture"
        aria-label=${label}
        aria-describedby=${describedBy}
        style=${{ touchAction: placed && !placed.panorama && placed.zoom <= placed.fit ? "pan-y" : "none" }}
      ></canvas>
      ${placed && !placed.panorama && frame && html`<i class="frame" style=${around(frame, placed, size)}></i>`}
      ${large && !placed.panorama && point && html`<i class="mark" style=${around({ ...point, width: 1, height: 1 }, placed, size)}></i>`}
    </div>
  `;
}

// The pixels of the picture between two points of the canvas, null if there are none.
function between(a, b, { left, top, zoom }, data) {
  const ends = (one, other, start, length) => {
    const [low, high] = [Math.min(one, other), Math.max(one, other)].map((each) => (each - start) / zoom);
    return [Math.max(0, Math.floor(low)), Math.min(length, Math.ceil(high))];
  };
  const [x, right] = ends(a.x, b.x, left, data.width);
  const [y, bottom] = ends(a.y, b.y, top, data.height);
  return right > x && bottom > y ? { x, y, width: right - x, height: bottom - y } : null;
}

const around = ({ x, y, width, height }, { left, top, zoom }, { ratio }) => ({
  left: `${(left + x * zoom) / ratio}px`,
  top: `${(top + y * zoom) / ratio}px`,
  width: `${(width * zoom) / ratio}px`,
  height: `${(height * zoom) / ratio}px`,
});
