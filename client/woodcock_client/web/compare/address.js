// What the address says of a comparison, so that it can be shared: /compare?renders=id,id&mode=split&…, and the view of
// the pictures as viewer/view.js has it.

import { go } from "../navigation.js";
import { writeView } from "../viewer/view.js";
import { MAPS } from "./maps.js";

export const MOST = 4;
export const MODES = ["flip", "split", "side", "map"];

// {ids, mode, shown, reference, split, map}: shown and reference are places in ids; split: where the line is, 0 to 1.
export function readAddress(query) {
  const ids = [...new Set((query.get("renders") ?? "").split(",").filter(Boolean))].slice(0, MOST);
  const place = (name, otherwise) => {
    const at = Number(query.get(name)) - 1;
    return Number.isInteger(at) && at >= 0 && at < ids.length ? at : otherwise;
  };
  const split = Number.parseFloat(query.get("split"));
  return {
    ids,
    mode: MODES.includes(query.get("mode")) ? query.get("mode") : "flip",
    shown: place("show", 0),
    reference: place("reference", 0),
    split: split >= 0 && split <= 1 ? split : 0.5,
    map: Object.hasOwn(MAPS, query.get("difference")) ? query.get("difference") : "difference",
  };
}

// Puts it into the address in place of what was there; what is as it would be anyway is left out.
export function writeAddress({ ids, mode, shown, reference, split, map }, view) {
  const query = writeView(view, new URLSearchParams({ renders: ids.join(",") }));
  const put = (name, value, otherwise) => value !== otherwise && query.set(name, value);
  put("mode", mode, "flip");
  put("show", shown + 1, 1);
  put("reference", reference + 1, 1);
  put("split", Number(split.toFixed(3)), 0.5);
  put("difference", map, "difference");
  history.replaceState(history.state, "", addressOf(query));
}

const addressOf = (query) => `/compare?${query.toString().replace(/%2C/g, ",")}`;

// The page that compares renders of these ids.
export const goTo = (ids) => go(addressOf(new URLSearchParams({ renders: ids.join(",") })));
