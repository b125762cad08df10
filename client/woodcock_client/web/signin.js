// Where a service that asks for tokens is told one. The browser keeps it in a cookie that no script can read.

import { useState } from "preact/hooks";
import { signIn } from "./api.js";
import { html } from "./html.js";

export function SignIn({ onDone }) {
  const [fault, setFault] = useState(null);
  const [busy, setBusy] = useState(false);

  async function submit(event) {
    event.preventDefault();
    const token = new FormData(event.target).get("token").trim();
    setBusy(true);
    try {
      await signIn(token);
      onDone();
    } catch (problem) {
      setFault(problem.message);
      setBusy(false);
    }
  }

  return html`
    <section class="notice">
      <h1>Sign in</h1>
      <p>This service asks for a token. Whoever runs it makes one with <code>woodcock token create NAME</code>.</p>
      <form class="signin" onSubmit=${submit}>
        <label for="token">Token</label>
        <input id="token" name="token" type="password" required autocomplete="current-password" aria-describedby="token-fault" />
        <button disabled=${busy}>Sign in</button>
        <p id="token-fault" class="fault" role="alert">${fault}</p>
      </form>
    </section>
  `;
}
