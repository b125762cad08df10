// The editor's looks, in the colours of the page: variables reach into its shadow tree, rules do not.

import { HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { EditorView } from "@codemirror/view";
import { tags } from "@lezer/highlight";

const popup = {
  border: "1px solid var(--line)",
  borderRadius: "var(--radius)",
  backgroundColor: "var(--raised)",
  color: "var(--text)",
};

export const looks = [
  syntaxHighlighting(
    HighlightStyle.define([
      { tag: tags.propertyName, color: "var(--split-2)" },
      { tag: tags.string, color: "var(--split-3)" },
      { tag: [tags.number, tags.bool, tags.null], color: "var(--accent)" },
    ]),
  ),
  EditorView.theme({
    "&": { height: "100%", backgroundColor: "var(--raised)", color: "var(--text)", fontSize: "13.5px" },
    "&.cm-focused": { outline: "none" },
    ".cm-scroller": {
      lineHeight: "1.5",
      fontFamily: 'ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace',
      overflow: "auto",
    },
    ".cm-content": { padding: "8px 0", caretColor: "var(--text)" },
    ".cm-cursor": { borderLeftColor: "var(--text)" },
    ".cm-gutters": { border: "none", backgroundColor: "var(--raised)", color: "var(--quiet)" },
    ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--text) 5%, transparent)" },
    "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
      backgroundColor: "color-mix(in srgb, var(--accent) 30%, transparent)",
    },
    "&.cm-focused .cm-matchingBracket": { backgroundColor: "color-mix(in srgb, var(--accent) 25%, transparent)" },
    ".cm-snippetField": { backgroundColor: "color-mix(in srgb, var(--accent) 18%, transparent)" },
    ".cm-lintRange-error": {
      backgroundImage: "none",
      textDecoration: "underline wavy var(--failed) 1.5px",
      textUnderlineOffset: "3px",
    },
    ".cm-lint-marker-error": { content: '""', width: "8px", height: "8px", marginTop: "6px", borderRadius: "50%", backgroundColor: "var(--failed)" },
    ".cm-tooltip": { ...popup, maxWidth: "min(440px, 90vw)", zIndex: "10" },
    ".cm-tooltip.cm-completionInfo": { ...popup, padding: "8px 10px", whiteSpace: "normal" },
    "@media (max-width: 520px)": { ".cm-tooltip.cm-completionInfo": { display: "none" } }, // it would lie on the list
    ".cm-tooltip-autocomplete > ul": { fontFamily: "inherit" },
    ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "3px 8px" },
    ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": { backgroundColor: "var(--accent)", color: "var(--on-accent)" },
    ".cm-completionDetail": { color: "var(--quiet)", fontStyle: "normal" },
    "li[aria-selected] .cm-completionDetail": { color: "inherit" },
    ".cm-diagnostic-error": { borderLeft: "3px solid var(--failed)" },
    ".note": { padding: "8px 10px" },
    ".note p": { margin: "4px 0 0", color: "var(--quiet)" },
  }),
];
