// What a finished render says of itself, below its picture.

import { html } from "../html.js";
import { title } from "../format.js";
import { Certificate } from "./certificate.js";
import { ErrorChart } from "./chart.js";
import { seriesOf } from "./curves.js";
import { Lean } from "./lean.js";
import { Media } from "./media.js";
import { Provenance } from "./provenance.js";
import { Times } from "./times.js";

export function Report({ job, report }) {
  const { certificate, slope, devices, seconds, kinds } = report;
  const media = devices?.[0]?.media ?? [];
  return html`
    <div class="report">
      <div>
        ${report.error && html`<${ErrorChart} series=${[seriesOf(title(job), report)]} />`}
        ${report.error?.length > 1 && slope?.says && html`<p class="explain said">${slope.says}</p>`}
        ${seconds && html`<${Times} seconds=${seconds} utilisation=${report.utilisation} />`}
        ${kinds && html`<${Lean} kinds=${kinds} program=${report.program} gain=${report.gain} />`}
      </div>
      <div>
        ${certificate && html`<${Certificate} certificate=${certificate} />`}
        ${media.length > 0 && html`<${Media} media=${media} />`}
        <${Provenance} job=${job} report=${report} />
      </div>
    </div>
  `;
}
