// Markup as tagged templates. Values are always set as text or properties, never parsed as HTML.

import htm from "htm";
import { h } from "preact";

export const html = htm.bind(h);
