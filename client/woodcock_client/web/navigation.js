// Addresses within the gallery: a change of address changes the page without loading it again.

import { useEffect, useState } from "preact/hooks";

const CHANGED = "woodcock-address";

const here = () => location.pathname + location.search;

// Goes to another address of the gallery; replace: in place of this one in the history. Pages that keep their state in
// the address, and are told of nothing by it, use history.replaceState alone.
export function go(address, { replace = false } = {}) {
  history[replace ? "replaceState" : "pushState"](null, "", address);
  dispatchEvent(new Event(CHANGED));
}

// The address as it is now: {pathname, searchParams}, anew at each change. Plain clicks on links that have
// `data-route` go through here.
export function useAddress() {
  const [address, setAddress] = useState(here);
  useEffect(() => {
    const onClick = (event) => {
      const link = event.target.closest?.("a[data-route]");
      const plain = event.button === 0 && !(event.metaKey || event.ctrlKey || event.shiftKey || event.altKey);
      if (!link || !plain || event.defaultPrevented) return;
      event.preventDefault();
      go(link.href);
    };
    const onChange = () => setAddress(here());
    addEventListener("click", onClick);
    addEventListener("popstate", onChange);
    addEventListener(CHANGED, onChange);
    return () => {
      removeEventListener("click", onClick);
      removeEventListener("popstate", onChange);
      removeEventListener(CHANGED, onChange);
    };
  }, []);
  return new URL(address, location.origin);
}
