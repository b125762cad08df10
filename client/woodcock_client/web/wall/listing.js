// The wall's jobs, all or those of a batch, newest first: pages as they are scrolled to, and what is new or moving, asked
// for again and again.
//
// One listing lives as long as the tab, so that coming back from a render finds the wall as it was left. It polls
// (two requests a beat at most for any number of running jobs) because browsers allow six connections to one address
// over HTTP/1.1: an open stream for each card would leave none for the pictures.

import { getJob, isActive, listJobs } from "../api.js";

const PAGE = 48;
const BEAT = 2000; // ms between looks while something renders
const REST = 4000; // ms when nothing does
const OLDEST = 4; // active jobs beyond the first page that are looked at each beat; the oldest render first

const NOTHING = { jobs: null, next: null, problem: null, away: false, loading: false };
export const listing = { batch: null, ...NOTHING };

let tell = () => {};
let timer;
let watching = false;

function change(values) {
  Object.assign(listing, values);
  tell();
}

// The jobs with `fresh` put in place of what was known of them, and the unknown ones in front.
function merged(fresh) {
  const known = new Map(listing.jobs.map((job) => [job.id, job]));
  const added = fresh.filter((job) => !known.has(job.id));
  for (const job of fresh) known.set(job.id, job);
  return [...added, ...listing.jobs.map((job) => known.get(job.id))];
}

export async function more() {
  if (listing.loading) return;
  const { batch } = listing;
  change({ loading: true });
  try {
    const { items, next } = await listJobs({ limit: PAGE, cursor: listing.next, batch });
    if (listing.batch !== batch) return;
    const have = new Set(listing.jobs?.map((job) => job.id));
    const jobs = [...(listing.jobs ?? []), ...items.filter((job) => !have.has(job.id))];
    change({ jobs, next, problem: null, away: false, loading: false });
  } catch (problem) {
    if (listing.batch === batch) change({ problem, loading: false });
  }
}

async function refresh() {
  const { batch } = listing;
  try {
    const { items, next } = await listJobs({ limit: PAGE, batch });
    if (listing.batch !== batch) return;
    const ids = new Set(items.map((job) => job.id));
    const overlaps = listing.jobs.length === 0 || listing.jobs.some((job) => ids.has(job.id));
    if (!overlaps) {
      // More arrived than one page holds: start over rather than leave a hole
      change({ jobs: items, next, away: false });
      return;
    }
    const beyond = listing.jobs.filter((job) => isActive(job) && !ids.has(job.id)).slice(-OLDEST);
    const asked = await Promise.allSettled(beyond.map((job) => getJob(job.id)));
    if (listing.batch !== batch) return;
    const moved = asked.flatMap((one) => one.value ?? []); // one that cannot be had stays as it was known
    const first = listing.jobs.length === 0;
    change({ jobs: merged([...items, ...moved]), away: false, ...(first && { next }) });
  } catch {
    change({ away: true });
  }
}

async function beat() {
  clearTimeout(timer);
  if (!document.hidden && !listing.loading) await (listing.jobs ? refresh() : more());
  clearTimeout(timer); // another beat may have come while this one waited
  if (watching) timer = setTimeout(beat, listing.jobs?.some(isActive) ? BEAT : REST);
}

const onVisibility = () => document.hidden || beat();

// Keeps the listing fresh, and calls onChange after each change, until the returned function is called. batch: whose
// jobs are listed, null for all.
export function watch(batch, onChange) {
  if (listing.batch !== batch) Object.assign(listing, { batch, ...NOTHING });
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
