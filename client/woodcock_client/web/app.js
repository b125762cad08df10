// The shell: the bar above every page, and the page that the address names (pages.js).

import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { SIGNED_OUT } from "./api.js";
import { html } from "./html.js";
import { useAddress } from "./navigation.js";
import { pageAt } from "./pages.js";
import { SignIn } from "./signin.js";
import { Notice } from "./states.js";
import { Toast } from "./undo.js";

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

// The component of a page once it is loaded; the page before stays until then.
function usePage(address) {
  const [shown, setShown] = useState(null);
  const wanted = address.pathname + address.search;
  useEffect(() => {
    let current = true;
    const page = pageAt(address);
    if (page === null) setShown({ unknown: true });
    else
      page.load().then(
        (Page) => current && setShown({ Page, ...page, query: address.searchParams }),
        () => current && setShown({ lost: true }),
      );
    return () => (current = false);
  }, [wanted]);
  return shown;
}

const LINKS = [
  ["/", "Renders"],
  ["/fleet", "Fleet"],
];

function App() {
  const address = useAddress();
  const shown = usePage(address);
  const [signedOut, onSignedIn] = useSignedOut();
  return html`
    <a class="skip" href="#main">Skip to content</a>
    <header class="bar">
      <a class="brand" href="/" data-route><img src="/web/icon.svg" alt="" width="22" height="22" />Woodcock</a>
      <nav aria-label="Service">
        ${LINKS.map(([href, name]) => html`<a key=${href} href=${href} aria-current=${address.pathname === href ? "page" : null} data-route>${name}</a>`)}
        <a href="/docs">API</a>
      </nav>
    </header>
    <main id="main" tabindex="-1">
      ${signedOut ? html`<${SignIn} onDone=${onSignedIn} />` : shown && html`<${Shown} shown=${shown} />`}
    </main>
    <${Toast} />
  `;
}

function Shown({ shown: { Page, key, parameters, query, unknown, lost } }) {
  const back = html`<a class="button" href="/" data-route>All renders</a>`;
  if (unknown) return html`<${Notice} title="There is no such page" action=${back} />`;
  if (lost) {
    return html`
      <${Notice} title="This page cannot be loaded" action=${back}>
        <p>The service does not answer, or has become another version. Load the page again once it does.</p>
      <//>
    `;
  }
  return html`<${Page} key=${key} ...${parameters} query=${query} />`;
}

history.scrollRestoration = "manual"; // the wall restores its own place once its cards are back
render(html`<${App} />`, document.getElementById("app"));
