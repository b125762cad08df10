// What fingers, a mouse and keys do to a picture: it is moved, made larger, or a part of it is chosen.

const NOTCH = 0.0015; // of a wheel: what one of its pixels does to the logarithm of the zoom
const LINE = 16; // pixels of a wheel that counts in lines
const STEP = 48; // pixels that a key moves the picture by
const KEYS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOM_KEYS = { "+": Math.SQRT2, "=": Math.SQRT2, "-": Math.SQRT1_2, _: Math.SQRT1_2 };

// Listens to an element. Points and distances are in pixels of the page, from the element's upper left corner.
//
// onMove(dx, dy), onZoom(factor, point); onPoint(point or null), and onMiddle() when keys are used; onChoose(from, to, done) while a rectangle is chosen with
// the shift key held; onFit() and onOne() for all of it, and for its own size. Returns a function that stops it.
export function listen(element, { onMove, onZoom, onPoint, onMiddle, onChoose, onFit, onOne }) {
  const held = new Map(); // points by pointer
  let from = null; // where a rectangle begins

  const pointOf = (event) => {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };

  function down(event) {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    held.set(event.pointerId, pointOf(event));
    from = event.shiftKey && held.size === 1 ? pointOf(event) : null;
    if (from) event.preventDefault(); // no text is to be selected
  }

  function move(event) {
    const point = pointOf(event);
    if (event.pointerType !== "touch" || held.size === 1) onPoint(point);
    const before = held.get(event.pointerId);
    if (!before) return;
    const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, each]) => each);
    held.set(event.pointerId, point);
    if (from) onChoose(from, point, false);
    else if (other) {
      const apart = (a) => Math.hypot(a.x - other.x, a.y - other.y) || 1;
      onZoom(apart(point) / apart(before), { x: (point.x + other.x) / 2, y: (point.y + other.y) / 2 });
      onMove((point.x - before.x) / 2, (point.y - before.y) / 2);
    } else if (event.pointerType !== "touch" || element.style.touchAction === "none") {
      onMove(point.x - before.x, point.y - before.y); // else a finger moves the page
    }
  }

  function up(event) {
    if (from && held.has(event.pointerId)) onChoose(from, pointOf(event), true);
    from = null;
    held.delete(event.pointerId);
  }

  function wheel(event) {
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : LINE * event.deltaY;
    // A touch pad's pinch comes as a wheel with the control key, in small steps.
    onZoom(Math.exp(-pixels * NOTCH * (event.ctrlKey ? 8 : 1)), pointOf(event));
  }

  function key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = KEYS[event.key]?.map((each) => each * STEP * (event.shiftKey ? 4 : 1));
    if (step) onMove(...step);
    else if (ZOOM_KEYS[event.key]) onZoom(ZOOM_KEYS[event.key]);
    else if (event.key === "0") onFit();
    else if (event.key === "1") onOne();
    else return;
    event.preventDefault();
    onMiddle();
  }

  const leave = () => onPoint(null);
  const listeners = { pointerdown: down, pointermove: move, pointerup: up, pointercancel: up, pointerleave: leave, wheel, keydown: key };
  for (const [name, listener] of Object.entries(listeners)) element.addEventListener(name, listener, { passive: false });
  return () => {
    for (const [name, listener] of Object.entries(listeners)) element.removeEventListener(name, listener);
  };
}
