// What the wall is narrowed to. The address says it, in the words of the API's listing.

const WORDS = ["text", "state", "tag", "device", "integrator", "batch"];

// Of an address, in one order, so that the same filter is the same text.
export function filterOf(query) {
  const filter = new URLSearchParams();
  for (const word of WORDS) for (const value of query.getAll(word)) if (value) filter.append(word, value);
  return filter.toString();
}

// The filter with other values of one word; none: without it.
export function narrowed(filter, word, values) {
  const query = new URLSearchParams(filter);
  query.delete(word);
  for (const value of values) query.append(word, value);
  return filterOf(query);
}

export const addressOf = (filter) => (filter ? `/?${filter}` : "/");
