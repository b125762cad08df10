// Which page an address shows. Each is in a folder of its own and loaded when it is first gone to.
//
// load: the page's component. It is given what the path names in its groups, and `query` (URLSearchParams); key: what
// makes it another page, so that nothing of the last one stays.

export const PAGES = [
  {
    path: /^\/$/,
    load: () => import("./wall/wall.js").then((module) => module.Wall),
    key: () => "wall",
  },
  {
    path: /^\/renders\/(?<id>[^/]+)\/?$/,
    load: () => import("./render/render.js").then((module) => module.Render),
    key: ({ id }) => `render ${id}`,
  },
  {
    path: /^\/fleet\/?$/,
    load: () => import("./fleet/fleet.js").then((module) => module.Fleet),
    key: () => "fleet",
  },
  {
    path: /^\/batches\/(?<id>[^/]+)\/?$/,
    load: () => import("./batch/batch.js").then((module) => module.Batch),
    key: ({ id }) => `batch ${id}`,
  },
];

// {load, key, parameters} of an address, null where there is no such page.
export function pageAt({ pathname, searchParams }) {
  for (const { path, load, key } of PAGES) {
    const found = pathname.match(path);
    if (!found) continue;
    try {
      const named = Object.entries(found.groups ?? {});
      const parameters = Object.fromEntries(named.map(([name, value]) => [name, decodeURIComponent(value)]));
      return { load, key: key(parameters, searchParams), parameters };
    } catch {
      return null; // a stray % in the address
    }
  }
  return null;
}
