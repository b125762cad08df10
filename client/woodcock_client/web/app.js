// The shell and the router: `/` is the wall, `/?batch={id}` that of a batch, `/renders/{id}` one render.

import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { SIGNED_OUT } from "./api.js";
import { html } from "./html.js";
import { Render } from "./render.js";
import { SignIn } from "./signin.js";
import { Notice } from "./states.js";
import { Wall } from "./wall.js";

function route(address) {
  const { pathname: path, searchParams: query } = new URL(address, location.origin);
  const [, id] = path.match(/^\/renders\/([^/]+)\/?$/) ?? [];
  try {
    if (id) return { id: decodeURIComponent(id) };
  } catch {
    return { unknown: true }; // a stray % in the address
  }
  return path === "/" ? { batch: query.get("batch") } : { unknown: true };
}

// A plain click on a link within the gallery changes the page without loading it again.
function useRouter() {
  const here = () => location.pathname + location.search;
  const [address, setAddress] = useState(here);
  useEffect(() => {
    const onClick = (event) => {
      const link = event.target.closest?.("a[data-route]");
      const plain = event.button === 0 && !(event.metaKey || event.ctrlKey || event.shiftKey || event.altKey);
      if (!link || !plain || event.defaultPrevented) return;
      event.preventDefault();
      history.pushState(null, "", link.href);
      setAddress(here());
    };
    const onPop = () => setAddress(here());
    addEventListener("click", onClick);
    addEventListener("popstate", onPop);
    return () => {
      removeEventListener("click", onClick);
      removeEventListener("popstate", onPop);
    };
  }, []);
  return route(address);
}

// Whether the service has asked who is there, and a function for when it has been told.
function useSignedOut() {
  const [signedOut, setSignedOut] = useState(false);
  useEffect(() => {
    const onSignedOut = () => setSignedOut(true);
    addEventListener(SIGNED_OUT, onSignedOut);
    return () => removeEventListener(SIGNED_OUT, onSignedOut);
  }, []);
  return [signedOut, () => setSignedOut(false)];
}

function App() {
  const { id, batch, unknown } = useRouter();
  const [signedOut, onSignedIn] = useSignedOut();
  return html`
    <a class="skip" href="#main">Skip to content</a>
    <header class="bar">
      <a class="brand" href="/" data-route><img src="/web/icon.svg" alt="" width="22" height="22" />Woodcock</a>
      <nav aria-label="Service"><a href="/docs">API</a></nav>
    </header>
    <main id="main" tabindex="-1">
      ${signedOut ? html`<${SignIn} onDone=${onSignedIn} />` : unknown
        ? html`<${Notice} title="There is no such page" action=${html`<a class="button" href="/" data-route>All renders</a>`} />`
        : id
          ? html`<${Render} key=${id} id=${id} />`
          : html`<${Wall} key=${batch} batch=${batch} />`}
    </main>
  `;
}

history.scrollRestoration = "manual"; // the wall restores its own place once its cards are back
render(html`<${App} />`, document.getElementById("app"));
