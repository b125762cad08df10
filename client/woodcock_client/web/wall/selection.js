// Which cards are selected. It lives as long as the tab, as the listing does.

export const selection = { ids: new Set(), from: null };

export function toggle(id) {
  if (!selection.ids.delete(id)) selection.ids.add(id);
  selection.from = id;
}

// All from the one that was touched last to this one; jobs: in the order of the wall.
export function reach(jobs, id) {
  const [from, to] = [selection.from, id].map((end) => jobs.findIndex((job) => job.id === end));
  if (from < 0) return toggle(id);
  for (const job of jobs.slice(Math.min(from, to), Math.max(from, to) + 1)) selection.ids.add(job.id);
  selection.from = id;
  return undefined;
}

export function clear() {
  selection.ids.clear();
  selection.from = null;
}
