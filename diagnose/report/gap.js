// Draws the figures of a gap report. Helpers: plots.js, which comes before this file; report.js calls from DRAW.

const GAP_PANEL = { height: 200, least: 330, gap: 62, labelHeight: 6.4 };

function gapColours() {
  return { measured: colour("ink"), before: colour("base"), after: colour("curve") };
}

function gapRows(state) {
  const probe = state.payload.probes[state.channel];
  if (state.series === 1) return { before: probe.leftBefore, after: probe.leftAfter, measured: probe.noise, left: true, unit: probe.unit };
  return { before: probe.before, after: probe.after, measured: probe.measured, noise: probe.noise, left: false, unit: probe.unit };
}

// The same range in every panel, so that conditions can be compared; far below the noise there is nothing to see.
function gapRange(rows, noise, log) {
  const top = highest([rows.before, rows.after, rows.measured].flat(2), 1) || 1;
  if (!log) return [0, 1.08 * top];
  const low = lowestPositive(noise.flat(), top * 1e-4);
  return [Math.log10(Math.min(Math.max(0.5 * low, top * 1e-6), top / 10)), Math.log10(1.6 * top)];
}

function gapPanel(state, rows, index, labels, axes) {
  const tints = gapColours(), unit = plotText(rows.unit), at = labels.map((_, i) => i);
  const bars = (values, name, shift) => Object.assign({
    type: "bar", name: name, x: at.map((i) => i + shift), y: values, width: 0.36, marker: { color: tints[name] },
    text: labels, textposition: "none", hovertemplate: `%{text}, ${rows.left ? "left " : "simulated "}${name}: %{y:.4g} ${unit}<extra></extra>`,
  }, axes);
  const marks = Object.assign({
    type: "scatter", mode: "markers", name: rows.left ? "noise" : "measured", x: at, y: rows.measured[index], text: labels,
    marker: { color: tints.measured, size: rows.left ? 15 : 7, symbol: rows.left ? "line-ew-open" : "diamond", line: { width: 2 } },
    hovertemplate: `%{text}, ${rows.left ? "noise" : "measured"}: %{y:.4g} ${unit}<extra></extra>`,
  }, axes);
  if (!rows.left) marks.error_y = { type: "data", array: rows.noise[index].map((value) => 2 * value), color: tints.measured, thickness: 1, width: 3 };
  return [bars(rows.before[index], "before", -0.2), bars(rows.after[index], "after", 0.2), marks];
}

function drawGapOrders(state) {
  const labels = state.payload.orders.map(plotText), conditions = state.payload.conditions, rows = gapRows(state);
  const wide = state.canvas.clientWidth, columns = Math.max(1, Math.min(Math.floor(wide / GAP_PANEL.least), conditions.length, 3));
  const lines = Math.ceil(conditions.length / columns), log = state.scale === "log";
  const range = gapRange(rows, state.payload.probes[state.channel].noise, log);
  // Labels that do not fit side by side stand upright and need room below.
  const longest = Math.max(...labels.map((one) => one.length));
  const upright = LABEL_WIDTH * (longest + 1) * labels.length > wide / columns - 60;
  const gap = GAP_PANEL.gap + (upright ? Math.max(GAP_PANEL.labelHeight * longest - 12, 0) : 0);
  const plan = layout(state.canvas, { height: lines * (GAP_PANEL.height + gap) + 6, barmode: "overlay" });
  plan.margin = { l: 52, r: 8, t: 22, b: gap - 24 };
  const inside = plan.height - plan.margin.t - plan.margin.b, space = 0.09, width = (1 - space * (columns - 1)) / columns;
  plan.annotations = [];
  const traces = [];
  conditions.forEach((condition, i) => {
    const column = i % columns, row = Math.floor(i / columns), name = i ? i + 1 : "";
    const left = column * (width + space), top = 1 - (row * (GAP_PANEL.height + gap)) / inside;
    const low = Math.max(top - GAP_PANEL.height / inside, 0);
    plan["xaxis" + name] = axis("", { domain: [left, Math.min(left + width, 1)], anchor: "y" + name, range: [-0.6, labels.length - 0.4], tickvals: labels.map((_, k) => k), ticktext: labels, tickangle: upright ? 90 : 0, fixedrange: true, ticks: "" });
    plan["yaxis" + name] = axis("", Object.assign({ domain: [low, top], anchor: "x" + name, range: range, fixedrange: true }, log ? { type: "log", dtick: 1, exponentformat: "power", minexponent: 3 } : { nticks: 5, exponentformat: "power" }));
    const note = (condition.heldOut ? " (held out)" : "") + (column ? "" : `, ${rows.unit}`);
    plan.annotations.push({ x: left, y: top, xref: "paper", yref: "paper", xanchor: "left", yanchor: "bottom", text: `<b>${plotText(condition.name)}</b>${plotText(note)}`, showarrow: false });
    traces.push(...gapPanel(state, rows, i, labels, { xaxis: "x" + name, yaxis: "y" + name }));
  });
  state.figure.querySelector(".key-measured").textContent = rows.left ? "noise" : "measured";
  caption(state, rows.left ? "What is left: distance between measured and simulated line, phase included; the dash is the noise." : "");
  return show(state.canvas, traces, plan);
}

function gapAxis(state) {
  const all = state.payload.conditions, order = all.map((_, i) => i);
  const oneLoad = new Set(all.map((one) => one.load)).size < 2;
  order.sort((a, b) => (oneLoad ? 0 : (all[a].load || 0) - (all[b].load || 0)) || all[a].speed - all[b].speed);
  return { order: order, numeric: oneLoad, x: order.map((i) => (oneLoad ? all[i].speed : plotText(all[i].name))) };
}

function drawGapConditions(state) {
  const probe = state.payload.probes[state.channel], phase = state.axis === "phase", line = state.series;
  const at = gapAxis(state), tints = gapColours(), all = state.payload.conditions;
  const picked = (rows) => at.order.map((i) => rows[i][line]);
  const sources = phase ? probe.phases : [probe.measured, probe.before, probe.after];
  const names = at.order.map((i) => plotText(all[i].name) + (all[i].heldOut ? " (held out)" : ""));
  const unit = phase ? "°" : plotText(probe.unit);
  const trace = (rows, word, look) => Object.assign({
    type: "scatter", mode: at.numeric ? "lines+markers" : "markers", name: word, x: at.x, y: picked(rows), text: names,
    hovertemplate: `%{text}<br>${word}: %{y:.4g} ${unit}<extra></extra>`,
  }, look);
  const measured = trace(sources[0], "measured", {
    mode: "markers", marker: { color: tints.measured, size: 10, symbol: at.order.map((i) => (all[i].heldOut ? "circle-open" : "diamond-open")), line: { width: 2 } },
  });
  if (!phase) measured.error_y = { type: "data", array: picked(probe.noise).map((value) => 2 * value), color: tints.measured, thickness: 1, width: 3 };
  const traces = [
    trace(sources[1], "simulated before", { line: { color: tints.before, width: 1.5, dash: "dash" }, marker: { color: tints.before, size: 8, symbol: "square" } }),
    trace(sources[2], "simulated after", { line: { color: tints.after, width: 1.5 }, marker: { color: tints.after, size: 6, symbol: "circle" } }),
    measured,
  ];
  const top = highest(traces.map((one) => one.y).flat(), 1) || 1;
  const longest = at.numeric ? 0 : Math.max(...at.x.map((one) => one.length));
  const upright = LABEL_WIDTH * (longest + 1) * at.x.length > state.canvas.clientWidth - MARGIN.left - MARGIN.right;
  const plan = layout(state.canvas, {
    xaxis: axis(at.numeric ? "Speed (rpm)" : "", at.numeric ? {} : { type: "category", tickangle: upright ? 90 : 0 }),
    yaxis: axis(`${plotText(state.payload.orders[line])} (${unit})`, phase ? { range: [-190, 190], dtick: 90 } : { range: [0, 1.08 * top], exponentformat: "power" }),
  });
  if (!at.numeric && upright) { plan.margin.b = 14 + GAP_PANEL.labelHeight * longest; plan.height += plan.margin.b - MARGIN.bottom; }
  caption(state, phase && !state.payload.phased[line] ? "Only the size of this line is compared: it keeps no phase to the shaft." : "");
  return show(state.canvas, traces, plan);
}

DRAW["gap-orders"] = drawGapOrders;
DRAW["gap-conditions"] = drawGapConditions;
