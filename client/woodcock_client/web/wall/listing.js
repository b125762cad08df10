// The jobs of the wall, newest first: pages as they are scrolled to, and what is new or moving, asked for again and again.
//
// One listing lives as long as the tab, so that coming back from a render finds the wall as it was left. It polls
// (a few requests a beat for any number of running jobs) because browsers allow six connections to one address
// over HTTP/1.1: an open stream for each card would leave none for the pictures.

import { getJob, isActive, listJobs } from "../api.js";
import { brief } from "../format.js";

const FIRST = 48; // of the page that is asked for again and again
const MORE = 200; // of the pages below it
const BEAT = 2000; // ms between looks while something renders
const REST = 4000; // ms when nothing does
const OLDEST = 4; // active jobs beyond the first page that are looked at each beat; the oldest render first
const TOP = 60; // pixels: who has scrolled no further sees what is new at once

// jobs: as cards show them, null before there are any; stale: they are those of another filter; fresh: what came in
// since the reader scrolled down; behind: so much did that the two do not meet; place: how far the wall is scrolled.
const NOTHING = { next: null, problem: null, away: false, loading: false, fresh: [], behind: false, place: 0 };
export const listing = { filter: null, jobs: null, stale: false, ...NOTHING };

let tell = () => {};
let timer;
let watching = false;

function change(values) {
  Object.assign(listing, values);
  tell();
}

// What a card shows of a job: ten thousand of them are kept.
function carded(job) {
  const { id, name, tags, state, batch, width, height, samples, fraction, created_at, relative_rmse, integrator, links } = job;
  const said = job.error ?? job.waiting;
  return {
    ...{ id, name, tags, state, batch, width, height, samples, fraction, created_at, relative_rmse, integrator },
    ...{ thumbnail: links.thumbnail, said: said && brief(said).slice(0, 200) },
  };
}

const list = async (asked) => {
  const { items, next } = await listJobs({ filter: listing.filter, ...asked });
  return { items: items.map(carded), next };
};

export async function more() {
  if (listing.loading) return;
  const { filter, stale } = listing;
  const first = stale || listing.jobs === null;
  change({ loading: true });
  try {
    const { items, next } = await list(first ? { limit: FIRST } : { limit: MORE, cursor: listing.next });
    if (listing.filter !== filter) return;
    const have = new Set(first ? [] : listing.jobs.map((job) => job.id));
    const jobs = [...(first ? [] : listing.jobs), ...items.filter((job) => !have.has(job.id))];
    change({ jobs, next, stale: false, problem: null, away: false, loading: false });
  } catch (problem) {
    if (listing.filter === filter) change({ problem, loading: false });
  }
}

async function refresh() {
  const { filter } = listing;
  try {
    const { items, next } = await list({ limit: FIRST });
    if (listing.filter !== filter) return;
    const known = new Set([...listing.fresh, ...listing.jobs].map((job) => job.id));
    const met = next === null || items.some((job) => known.has(job.id));
    if (!met && listing.place <= TOP) change({ jobs: items, next, fresh: [], behind: false, away: false });
    else if (!met) change({ behind: true, fresh: [], away: false });
    else {
      const newest = new Map(items.map((job) => [job.id, job]));
      const oldest = next === null ? "" : items.at(-1).id;
      const beyond = listing.jobs.filter((job) => isActive(job) && job.id < oldest).slice(-OLDEST);
      for (const [id, job] of await looked(beyond)) newest.set(id, job);
      if (listing.filter !== filter) return;
      // What is not on the page, though its place is there, was deleted, or the filter no longer means it
      const now = (job) => (newest.has(job.id) ? newest.get(job.id) : job.id < oldest ? job : null);
      const fresh = [...items.filter((job) => !known.has(job.id)), ...listing.fresh.map(now)].filter(Boolean);
      const jobs = listing.jobs.map(now).filter(Boolean);
      change({ fresh, jobs, away: false });
      if (listing.place <= TOP) show();
    }
  } catch {
    change({ away: true });
  }
}

// Jobs as they are now, by their ids; null for one that is no more.
async function looked(jobs) {
  const one = async ({ id }) => {
    try {
      return [[id, carded(await getJob(id))]];
    } catch (problem) {
      return problem.status === 404 ? [[id, null]] : []; // one that cannot be had stays as it was known
    }
  };
  return (await Promise.all(jobs.map(one))).flat();
}

// Puts what is new on top of the wall.
export function show() {
  if (listing.behind) change({ stale: true, behind: false, fresh: [] }), more();
  else if (listing.fresh.length > 0) change({ jobs: [...listing.fresh, ...listing.jobs], fresh: [] });
}

// A job is told anew by the service.
export function renew(job) {
  const anew = (known) => (known.id === job.id ? carded(job) : known);
  change({ jobs: listing.jobs.map(anew), fresh: listing.fresh.map(anew) });
}

async function beat() {
  clearTimeout(timer);
  if (!document.hidden && !listing.loading) await (listing.jobs && !listing.stale ? refresh() : more());
  clearTimeout(timer); // another beat may have come while this one waited
  if (watching) timer = setTimeout(beat, listing.jobs?.some(isActive) ? BEAT : REST);
}

const onVisibility = () => document.hidden || beat();

// Keeps the listing fresh, and calls onChange after each change, until the returned function is called.
export function watch(filter, onChange) {
  if (listing.filter !== filter) Object.assign(listing, NOTHING, { filter, stale: listing.jobs !== null });
  watching = true;
  tell = onChange;
  document.addEventListener("visibilitychange", onVisibility);
  beat();
  return () => {
    watching = false;
    tell = () => {};
    document.removeEventListener("visibilitychange", onVisibility);
    clearTimeout(timer);
  };
}
