// Draws the figures of the page of claims. Helpers: plots.js, which comes before this file.

const ZONE_COLOURS = ["#7cc79a", "#d3d86c", "#f2b351", "#e8735a"];
const DASHES = ["solid", "dash", "dot", "dashdot"];

function legendRows(canvas, names) {
  const width = Math.max(canvas.clientWidth - MARGIN.left - MARGIN.right, 200);
  let rows = 1, used = 0;
  for (const name of names) {
    const own = 45 + LABEL_WIDTH * name.length;
    if (used && used + own > width) { rows += 1; used = 0; }
    used += own;
  }
  return rows;
}

function withLegend(plan, canvas, names) {
  if (names.length < 2) return plan;
  plan.showlegend = true;
  plan.legend = { orientation: "h", x: 0, y: 1, yanchor: "bottom", xanchor: "left", font: { size: 12 }, traceorder: "normal" };
  plan.margin.t += 20 * legendRows(canvas, names) + 6;
  plan.height += plan.margin.t - 12;
  return plan;
}

function namedLines(marks, range, width) {
  const shapes = [], annotations = [];
  let freeFrom = -Infinity;
  for (const [label, x] of marks.slice().sort((a, b) => a[1] - b[1])) {
    shapes.push({ type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { color: colour("mute"), width: 1, dash: "dot" } });
    const pixel = range ? ((x - range[0]) / (range[1] - range[0])) * width : NaN;
    const half = (LABEL_WIDTH * label.length) / 2;
    if (pixel - half < freeFrom) continue;
    freeFrom = pixel + half + 4;
    annotations.push({ x: x, y: 1, yref: "paper", yanchor: "top", xanchor: "center", text: plotText(label), showarrow: false, font: { size: 11, color: colour("mute") }, bgcolor: colour("panel"), borderpad: 1 });
  }
  return { shapes: shapes, annotations: annotations };
}

function shownRange(state, traces) {
  if (state.range) return state.range;
  if (state.plan.range) return state.plan.range;
  const ends = traces.map((trace) => [trace.x[0], trace.x[trace.x.length - 1]]);
  return [Math.min(...ends.map((end) => end[0])), Math.max(...ends.map((end) => end[1]))];
}

// Room above the highest value for the names of the lines.
function logRange(plan, traces) {
  const top = Math.max(...traces.map((trace) => highest(trace.y, 0)));
  const low = plan.low || Math.min(...traces.map((trace) => lowestPositive(trace.y, Infinity))) / 2;
  const decades = Math.log10(top / low);
  return [Math.log10(low), Math.log10(top) + (plan.marks.length ? 0.14 : 0.04) * decades];
}

function drawCurves(state) {
  const plan = state.plan, bars = plan.kind === "bars";
  const traces = plan.variants[state.variant].map((one, index) => {
    const tint = colour("g" + (index % 8));
    const data = { name: plotText(one.name), x: one.curve ? expandX(one.curve) : one.x, y: one.curve ? one.curve.y : one.y };
    data.hovertemplate = `%{x:.5g}, %{y:.4g}<extra>${plotText(one.name)}</extra>`;
    if (bars) return Object.assign(data, { type: "bar", marker: { color: tint }, hovertemplate: `%{x}: %{y:.4g}<extra>${plotText(one.name)}</extra>` });
    const line = { color: tint, width: one.marked ? 1.6 : 1.1, dash: one.marked ? DASHES[Math.floor(index / 8) % 4] : "solid" };
    return Object.assign(data, { type: "scatter", mode: one.marked ? "lines+markers" : "lines", line: line, marker: { size: 7, symbol: index } });
  });
  const range = bars ? null : shownRange(state, traces);
  const pad = !bars && traces[0].mode === "lines+markers" ? 0.03 * (range[1] - range[0]) : 0;
  const marks = namedLines(plan.marks, range, state.canvas.clientWidth - MARGIN.left - MARGIN.right);
  const yAxis = plan.log ? { type: "log", range: logRange(plan, traces), exponentformat: "power", dtick: 1, minexponent: 3 } : { range: [0, (plan.marks.length ? 1.15 : 1.05) * Math.max(...traces.map((trace) => highest(trace.y, 0)))] };
  const made = layout(state.canvas, Object.assign({
    xaxis: axis(plotText(plan.x), bars ? { type: "category" } : { range: [range[0] - pad, range[1] + pad] }),
    yaxis: axis(plotText(plan.y), Object.assign({ fixedrange: true }, yAxis)), barmode: "group",
  }, marks));
  return show(state.canvas, traces, withLegend(made, state.canvas, traces.map((trace) => trace.name)));
}

// A map's colours change at the limits only: one colour a zone, no shades.
function zoneScale(limits) {
  const step = limits[1] - limits[0], low = limits[0] - step, high = limits[limits.length - 1] + step;
  const edges = [low, ...limits, high].map((value) => (value - low) / (high - low));
  const scale = ZONE_COLOURS.flatMap((tint, zone) => [[edges[zone], tint], [edges[zone + 1], tint]]);
  return { colorscale: scale, zmin: low, zmax: high };
}

function zonePanel(panel, index, look) {
  const axes = { x: panel.x, y: panel.y, z: panel.z, xaxis: "x" + (index || ""), yaxis: "y" + (index || "") };
  const line = (level, width) => Object.assign({
    type: "contour", showscale: false, showlegend: false, hoverinfo: "skip", colorscale: [[0, "#10181f"], [1, "#10181f"]],
    contours: { coloring: "none", start: level, end: level, size: 1, showlabels: width < 2, labelfont: { size: 10, color: "#10181f" } },
    line: { color: "#10181f", width: width },
  }, axes);
  const map = Object.assign({ type: "heatmap", showscale: false, hovertemplate: `${look} %{x:.3g} mm, %{y:.3g}°: %{z:.4g} ${plotText(panel.unit || "um")}<extra>${plotText(panel.name)}</extra>` }, zoneScale(panel.limits), axes);
  const contact = panel.contact ? [line(panel.contact, 3)] : [];
  return [map, ...panel.limits.map((limit) => line(limit, 0.8)), ...contact];
}

function drawZones(state) {
  const plan = state.plan, panels = plan.variants[0];
  const columns = state.canvas.clientWidth < 620 ? Math.min(panels.length, 2) : Math.min(panels.length, 4), rows = Math.ceil(panels.length / columns);
  const side = (state.canvas.clientWidth - 62) / columns, gap = 0.06, space = 0.16;
  const made = layout(state.canvas, {});
  made.margin = { l: 48, r: 14, t: 22, b: 48 };
  made.height = Math.round(rows * Math.min(1.15 * side, 320) + 70);
  const traces = [];
  made.annotations = [];
  panels.forEach((panel, i) => {
    const column = i % columns, row = Math.floor(i / columns), name = i ? i + 1 : "";
    const wide = (1 - gap * (columns - 1)) / columns, high = (1 - space * (rows - 1)) / rows;
    const left = column * (wide + gap), top = 1 - row * (high + space);
    made["xaxis" + name] = axis(row === rows - 1 ? plotText(plan.x) : "", { domain: [left, Math.min(left + wide, 1)], anchor: "y" + name, fixedrange: true, nticks: 4, ticks: "" });
    made["yaxis" + name] = axis(column ? "" : plotText(plan.y), { domain: [Math.max(top - high, 0), top], anchor: "x" + name, fixedrange: true, nticks: 5, showticklabels: !column, ticks: "" });
    made.annotations.push({ x: left + wide / 2, y: top, xref: "paper", yref: "paper", yanchor: "bottom", text: plotText(panel.name), xanchor: "center", showarrow: false });
    traces.push(...zonePanel(panel, i ? i + 1 : 0, ""));
  });
  return show(state.canvas, traces, made);
}

const claimFigures = [];

function drawFigure(state) {
  return state.plan.kind === "zones" ? drawZones(state) : drawCurves(state);
}

function startClaimFigure(figure, plan) {
  const state = { canvas: figure.querySelector(".canvas"), plan: plan, variant: 0, range: null };
  const select = figure.querySelector('select[data-role="variant"]');
  if (select) {
    state.variant = Number(select.value);
    select.addEventListener("change", () => { state.variant = Number(select.value); drawFigure(state); });
  }
  claimFigures.push(state);
  drawFigure(state);
  state.canvas.on("plotly_relayout", (change) => {
    const low = change["xaxis.range[0]"], high = change["xaxis.range[1]"];
    if (low === undefined && !change["xaxis.autorange"]) return;
    state.range = low === undefined ? null : [low, high];
    if (plan.kind === "curves") drawFigure(state);
  });
}

const plans = Object.assign({}, ...Array.from(document.querySelectorAll("script.figures"), (script) => JSON.parse(script.textContent)));
const waitingFigures = Array.from(document.querySelectorAll("figure[data-figure]"));
// One figure a turn, so that a phone shows the first while it draws the others.
function startNext() {
  const figure = waitingFigures.shift();
  if (!figure) { document.body.dataset.ready = "yes"; return; }
  startClaimFigure(figure, plans[figure.dataset.figure]);
  setTimeout(startNext, 0);
}
startNext();

function redrawAll() {
  claimFigures.forEach(drawFigure);
}
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
let resizing = 0;
window.addEventListener("resize", () => { clearTimeout(resizing); resizing = setTimeout(redrawAll, 200); });
window.addEventListener("beforeprint", () => { document.documentElement.dataset.print = "yes"; redrawAll(); });
window.addEventListener("afterprint", () => { delete document.documentElement.dataset.print; redrawAll(); });
