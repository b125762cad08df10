// The scene's text. In a shadow tree, where CodeMirror adopts its stylesheets: in the page it would write <style>
// elements, which the Content-Security-Policy refuses.

import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { json } from "@codemirror/lang-json";
import { bracketMatching, foldGutter, foldKeymap, indentOnInput } from "@codemirror/language";
import { lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { Compartment, EditorState } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { useEffect, useRef } from "preact/hooks";
import { html } from "../html.js";
import { completion } from "./completion.js";
import { diagnostics, syntaxFault } from "./faults.js";
import { hover } from "./hover.js";
import { looks } from "./looks.js";

const BASIC = [
  lineNumbers(),
  foldGutter(),
  history(),
  drawSelection(),
  indentOnInput(),
  bracketMatching(),
  closeBrackets(),
  highlightActiveLine(),
  lintGutter(),
  json(),
  looks,
  EditorView.lineWrapping,
  EditorView.contentAttributes.of({ "aria-label": "Scene, as JSON", tabindex: "0" }),
  // Not Tab: it leaves the editor, as it leaves any other field.
  keymap.of([...closeBracketsKeymap, ...defaultKeymap, ...historyKeymap, ...foldKeymap, ...completionKeymap, ...lintKeymap]),
];

// text: at the start, and as onText(text) told it after each change; view: a ref to the EditorView; schema: null
// until it is there; files: those that were uploaded; faults: of the scene as it is.
export function Editor({ text, view, onText, schema, files, faults }) {
  const host = useRef();
  const known = useRef(files);
  known.current = files;
  const aware = useRef(new Compartment());

  useEffect(() => {
    const root = host.current.shadowRoot ?? host.current.attachShadow({ mode: "open" });
    const told = EditorView.updateListener.of((update) => update.docChanged && onText(update.state.doc.toString()));
    const state = EditorState.create({ doc: text, extensions: [BASIC, aware.current.of([]), told] });
    view.current = new EditorView({ state, parent: root, root });
    return () => view.current.destroy();
  }, []);

  useEffect(() => {
    if (!schema) return;
    const help = [autocompletion({ override: [completion(schema, () => known.current)] }), hover(schema)];
    view.current.dispatch({ effects: aware.current.reconfigure(help) });
  }, [schema]);

  useEffect(() => {
    const { state } = view.current;
    const wrong = syntaxFault(state);
    const marks = wrong ? [{ ...wrong, severity: "error" }] : diagnostics(state, faults);
    view.current.dispatch(setDiagnostics(state, marks));
  }, [faults, text]);

  return html`<div class="editor" ref=${host}></div>`;
}

// Puts other text in its place; undoing brings the old one back.
export function replace(view, text) {
  view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text }, selection: { anchor: 0 }, scrollIntoView: true });
}

export function jump(view, { from, to }) {
  view.dispatch({ selection: { anchor: from, head: to }, effects: EditorView.scrollIntoView(from, { y: "center" }) });
  view.focus();
}
