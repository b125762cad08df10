// The cards: only those near the window are in the page, however many there are. Keys move among them.

import { useEffect, useLayoutEffect, useReducer, useRef, useState } from "preact/hooks";
import { html } from "../html.js";
import { Card } from "./card.js";
import { geometry, near } from "./geometry.js";

const PHONE = matchMedia("(max-width: 520px)");
const SETTLED = 120; // ms without scrolling after which pictures are asked for
const MARGIN = 12; // pixels between a card that is brought into view and the window's edge
const AHEAD = 3; // windows of cards that are asked for before they are scrolled to

let touched = null; // the id of the card that has or had the focus

// The width that the wall will have, before it is there.
function room() {
  const main = document.getElementById("main");
  const { paddingLeft, paddingRight } = getComputedStyle(main);
  return main.clientWidth - parseFloat(paddingLeft) - parseFloat(paddingRight);
}

// whole: there are no more than these; onSelect: of an id, and whether up to it; onEnd: more are wanted; covered: pixels
// at the window's lower edge that something lies on.
export function Grid({ jobs, whole, stale, selected, covered, place, onSelect, onClear, onEnd }) {
  const box = useRef();
  const [laid, setLaid] = useState(() => geometry(room(), PHONE.matches));
  const [seen, setSeen] = useState(() => near(laid, jobs.length, place, innerHeight));
  const [rushed, setRushed] = useState(false);
  const [, redraw] = useReducer((n) => n + 1, 0);
  const focus = useRef(null); // the id of the card that is to have the focus once it is there
  const anchor = useRef(null); // the card that stays at the window's edge while columns come and go

  const above = () => -box.current.getBoundingClientRect().top;
  const look = () => {
    const now = near(laid, jobs.length, above(), innerHeight);
    setSeen((before) => (Object.keys(now).every((key) => now[key] === before[key]) ? before : now));
  };
  const live = useRef();
  live.current = { look, laid, above };

  // Of the layout: what watches the wall must be gone as soon as the wall is.
  useLayoutEffect(() => {
    let last = scrollY;
    let timer;
    const onScroll = () => {
      if (Math.abs(scrollY - last) > innerHeight / 2) setRushed(true);
      last = scrollY;
      clearTimeout(timer);
      timer = setTimeout(() => setRushed(false), SETTLED);
      live.current.look();
    };
    const onResize = () => live.current.look();
    const observer = new ResizeObserver(() => {
      const { laid, above } = live.current;
      const now = geometry(box.current.clientWidth, PHONE.matches);
      if (now.width === laid.width) return;
      anchor.current = above() > 0 ? Math.floor(above() / laid.step) * laid.columns : null;
      setLaid(now);
    });
    observer.observe(box.current);
    addEventListener("scroll", onScroll, { passive: true });
    addEventListener("resize", onResize);
    return () => {
      clearTimeout(timer);
      observer.disconnect();
      removeEventListener("scroll", onScroll);
      removeEventListener("resize", onResize);
    };
  }, []);

  useLayoutEffect(() => {
    if (anchor.current !== null) scrollBy(0, Math.floor(anchor.current / laid.columns) * laid.step - above());
    anchor.current = null;
  }, [laid]);
  useLayoutEffect(look, [laid, jobs.length]);
  useLayoutEffect(() => {
    if (focus.current === null) return;
    const card = box.current.querySelector(`[data-id="${CSS.escape(focus.current)}"] .card`);
    if (card) {
      card.focus({ preventScroll: true });
      focus.current = null;
    }
  });
  const { first, last } = seen;
  useEffect(() => {
    if (last + AHEAD * (last - first) >= jobs.length) onEnd();
  }, [first, last, jobs.length]);

  // Brings the card at an index into view, and the focus to it.
  function moveTo(index) {
    const row = Math.floor(index / laid.columns) * laid.step;
    if (row - MARGIN < above()) scrollBy(0, row - MARGIN - above());
    const lack = row + laid.row + MARGIN + covered - above() - innerHeight;
    if (lack > 0) scrollBy(0, lack);
    touched = focus.current = jobs[index].id;
    look();
    redraw();
  }

  function onKeyDown(event) {
    const id = event.target.closest("[data-id]")?.dataset.id;
    const index = jobs.findIndex((job) => job.id === id);
    if (index < 0 || event.ctrlKey || event.metaKey || event.altKey) return;
    const moves = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -laid.columns, ArrowDown: laid.columns, Home: -index, End: jobs.length - 1 - index };
    const onCard = event.target.matches(".card");
    if (event.key in moves) {
      const to = index + moves[event.key];
      event.preventDefault();
      if (to >= 0 && to < jobs.length) moveTo(to);
    } else if (onCard && (event.key === " " || event.key.toLowerCase() === "x")) {
      event.preventDefault();
      onSelect(id, event.shiftKey);
    } else if (event.key === "Escape") onClear();
  }

  function onFocusIn(event) {
    const id = event.target.closest("[data-id]")?.dataset.id;
    if (!id || id === touched) return;
    touched = id;
    redraw();
  }

  // With Shift a click selects, where browsers would open a window.
  function onClick(event) {
    const card = event.shiftKey && event.target.closest(".card");
    if (!card) return;
    event.preventDefault();
    onSelect(card.parentElement.dataset.id, true);
  }

  const shown = jobs.slice(first, last);
  const reached = shown.some((job) => job.id === touched) ? touched : jobs[seen.top]?.id;
  const rows = Math.ceil(jobs.length / laid.columns);
  return html`
    <p id="wall-keys" hidden>Arrow keys move among the renders, Enter opens one, Space selects it.</p>
    <div class="wall" ref=${box} style=${{ height: `${Math.max(0, rows * laid.step - laid.down)}px` }}>
      <ul
        class=${`cards ${stale ? "stale" : ""} ${selected.size > 0 ? "selecting" : ""}`}
        role="list"
        aria-label="Renders"
        aria-describedby="wall-keys"
        aria-busy=${stale}
        style=${{
          transform: `translateY(${(first / laid.columns) * laid.step}px)`,
          gridTemplateColumns: `repeat(${laid.columns}, minmax(0, 1fr))`,
          gap: `${laid.down}px ${laid.across}px`,
          "--stage-height": `${laid.stage}px`,
        }}
        onKeyDown=${onKeyDown}
        onClick=${onClick}
        onFocusIn=${onFocusIn}
      >
        ${shown.map((job, place) => html`
          <${Card}
            key=${job.id}
            job=${job}
            index=${first + place}
            of=${whole ? jobs.length : -1}
            selected=${selected.has(job.id)}
            reached=${job.id === reached}
            rushed=${rushed}
            onSelect=${onSelect}
          />
        `)}
      </ul>
    </div>
  `;
}
