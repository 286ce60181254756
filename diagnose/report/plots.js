"use strict";
// Draws the figures. Every user text passes plotText() because plotly reads a little HTML in its labels.

const LABEL_HEIGHT = 14;
const LABEL_WIDTH = 6.4;
const MARGIN = { left: 62, right: 14, bottom: 44 };

function plotText(text) {
  return String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

function expandX(curve) {
  if (curve.x) return curve.x;
  let index = 0;
  return curve.i.map((step) => curve.x0 + curve.dx * (index += step));
}

function highest(values, fallback) {
  let top = -Infinity;
  for (const value of values) if (value !== null && value > top) top = value;
  return top === -Infinity ? fallback : top;
}

function lowestPositive(values, fallback) {
  let low = Infinity;
  for (const value of values) if (value !== null && value > 0 && value < low) low = value;
  return low === Infinity ? fallback : low;
}

function axis(title, more) {
  return Object.assign(
    {
      title: { text: title, font: { size: 12 }, standoff: 6 },
      gridcolor: colour("soft"), linecolor: colour("line"), zerolinecolor: colour("line"),
      tickfont: { size: 11 }, automargin: false, showline: true,
    },
    more,
  );
}

function layout(canvas, more) {
  return Object.assign(
    {
      height: canvas.clientWidth < 520 ? 300 : 350,
      width: document.documentElement.dataset.print ? 690 : undefined,
      autosize: true,
      margin: { l: MARGIN.left, r: MARGIN.right, t: 12, b: MARGIN.bottom },
      paper_bgcolor: colour("panel"), plot_bgcolor: colour("panel"),
      font: { color: colour("ink"), family: getComputedStyle(document.body).fontFamily, size: 12 },
      showlegend: false, hovermode: "closest",
      hoverlabel: { bgcolor: colour("panel"), bordercolor: colour("line"), font: { color: colour("ink") } },
      // On a touch screen a drag has to scroll the page; the range buttons zoom there.
      dragmode: window.matchMedia("(pointer: coarse)").matches ? false : "zoom",
    },
    more,
  );
}

function config() {
  return {
    responsive: true, displayModeBar: false, displaylogo: false, showTips: false,
  };
}

function show(canvas, traces, plan) {
  return Plotly.react(canvas, traces, plan, config());
}

// ---- spectra with cursors ----

function spectralTraces(channel, toAxis, inOrders) {
  const other = (x) => (inOrders ? "" : toAxis.speed ? x.map((f) => (f / toAxis.speed).toFixed(3)) : "");
  const unit = plotText(channel.unit);
  const xWord = inOrders ? "order %{x:.3f}" : "%{x:.2f} " + plotText(channel.xUnit) + (toAxis.speed ? " (order %{customdata})" : "");
  const trace = (curve, name, look) => {
    const x = expandX(curve);
    const data = { type: "scatter", mode: "lines", name: name, x: x.map(toAxis), y: curve.y, line: look };
    if (name === "floor") return Object.assign(data, { hoverinfo: "skip" });
    const custom = other(x);
    if (custom) data.customdata = custom;
    return Object.assign(data, { hovertemplate: `${xWord}<br>%{y:.4g} ${unit}<extra>${name === "base" ? "baseline" : ""}</extra>` });
  };
  const traces = [];
  if (channel.base) traces.push(trace(channel.base, "base", { color: colour("base"), width: 1 }));
  traces.push(trace(channel.curve, "curve", { color: colour("curve"), width: 1.2 }));
  if (channel.curve.floor) traces.push(trace(channel.curve.floor, "floor", { color: colour("floor"), width: 1.6 }));
  if (channel.lines.length) {
    traces.push({
      type: "scatter", mode: "markers", name: "lines",
      x: channel.lines.map((line) => toAxis(line.f)), y: channel.lines.map((line) => line.a),
      text: channel.lines.map((line) => plotText(line.text)),
      marker: { symbol: "circle-open", size: 9, color: colour("ring"), line: { width: 1.8 } },
      hovertemplate: `%{text}<br>%{y:.4g} ${unit}<extra></extra>`,
    });
  }
  return traces;
}

function nearRange(state, channel, toAxis) {
  const last = highest(expandX(channel.curve).slice(-1), 1);
  const marks = channel.lines.map((line) => line.f);
  state.payload.cursors.forEach((group, index) => {
    if (state.groups.has(index)) group.items.forEach((item) => marks.push(item[1]));
  });
  if (state.payload.speedHz) marks.push(10 * state.payload.speedHz);
  const end = Math.min(last, 1.1 * highest(marks.filter((f) => f <= last), last));
  return [0, toAxis(end > 0 ? end : last)];
}

function amplitudeRange(traces, range, log) {
  const seen = [];
  for (const trace of traces) {
    trace.x.forEach((x, index) => { if (x >= range[0] && x <= range[1]) seen.push(trace.y[index]); });
  }
  const top = highest(seen, 1);
  if (!log) return [0, 1.08 * (top || 1)];
  const floor = traces.find((trace) => trace.name === "floor");
  const low = floor ? 0.3 * lowestPositive(floor.y, top * 1e-4) : top * 1e-5;
  const positiveTop = top > 0 ? top : 1;
  return [Math.log10(Math.min(Math.max(low, positiveTop * 1e-6), positiveTop / 10)), Math.log10(1.6 * positiveTop)];
}

function cursorMarks(state, toAxis, range, width) {
  const shapes = [], annotations = [];
  let row = 0;
  state.payload.cursors.forEach((group, index) => {
    if (!state.groups.has(index)) return;
    let freeFrom = -Infinity;
    const tint = colour("g" + (index % 8));
    for (const [label, hertz] of group.items.slice().sort((a, b) => a[1] - b[1])) {
      const x = toAxis(hertz);
      shapes.push({
        type: "line", name: "cursor-" + index, xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: 1, layer: "below",
        line: { color: tint, width: 1, dash: "dot" },
      });
      const pixel = ((x - range[0]) / (range[1] - range[0])) * width;
      const half = (LABEL_WIDTH * label.length) / 2;
      // A label that would run into its neighbour, or out of the picture, is left out; zooming in brings it back.
      if (pixel - half < freeFrom || pixel - half < -MARGIN.left || pixel + half > width + MARGIN.right) continue;
      freeFrom = pixel + half + 5;
      annotations.push({
        x: x, xref: "x", y: 1, yref: "paper", yanchor: "bottom", yshift: 1 + LABEL_HEIGHT * row, showarrow: false,
        text: plotText(label), font: { size: 11, color: tint }, borderpad: 0,
      });
    }
    row += 1;
  });
  return { shapes: shapes, annotations: annotations, rows: row };
}

function drawSpectral(state) {
  const channel = state.payload[state.kind][state.channel];
  const speed = state.payload.speedHz;
  const inOrders = state.axis === "order" && speed;
  const toAxis = (f) => (inOrders ? f / speed : f);
  toAxis.speed = speed;
  const log = state.scale === "log";
  const traces = spectralTraces(channel, toAxis, inOrders);
  const whole = [0, toAxis(highest(expandX(channel.curve).slice(-1), 1))];
  const range = state.range ? state.range.map(toAxis) : state.zoom === "all" ? whole : nearRange(state, channel, toAxis);
  const marks = cursorMarks(state, toAxis, range, state.canvas.clientWidth - MARGIN.left - MARGIN.right);
  const plan = layout(state.canvas, {
    xaxis: axis(inOrders ? "Order of shaft speed" : `Frequency (${plotText(channel.xUnit)})`, { range: range, autorange: false }),
    yaxis: axis(`Amplitude (${plotText(channel.unit)})`, {
      type: log ? "log" : "linear", range: amplitudeRange(traces, range, log), fixedrange: true,
      exponentformat: "power", dtick: log ? 1 : undefined, minexponent: 4,
    }),
    shapes: marks.shapes, annotations: marks.annotations,
  });
  plan.margin.t = 10 + LABEL_HEIGHT * marks.rows;
  caption(state, channel.note);
  const drawn = show(state.canvas, traces, plan);
  if (!state.listening) {
    state.listening = true;
    state.canvas.on("plotly_relayout", (change) => followZoom(state, change));
    state.canvas.on("plotly_doubleclick", () => { state.range = null; state.zoom = "all"; drawSpectral(state); return false; });
  }
  return drawn;
}

function followZoom(state, change) {
  const low = change["xaxis.range[0]"], high = change["xaxis.range[1]"];
  if (change["xaxis.autorange"]) { state.range = null; state.zoom = "all"; }
  else if (low !== undefined) {
    const back = state.axis === "order" && state.payload.speedHz ? state.payload.speedHz : 1;
    state.range = [low * back, high * back];
  } else return;
  drawSpectral(state);
}

// ---- the other pictures ----

function drawWaveform(state) {
  const channel = state.payload.waveform[state.channel];
  const unit = plotText(channel.unit);
  const trace = {
    type: "scatter", mode: "lines", x: expandX(channel.curve), y: channel.curve.y, name: "curve",
    line: { color: colour("curve"), width: 1 }, hovertemplate: `%{x:.5g} ${plotText(channel.xUnit)}<br>%{y:.4g} ${unit}<extra></extra>`,
  };
  caption(state, channel.note);
  return show(state.canvas, [trace], layout(state.canvas, {
    xaxis: axis(`Time (${plotText(channel.xUnit)})`), yaxis: axis(`Signal (${unit})`, { exponentformat: "power" }),
  }));
}

function drawMap(state) {
  const map = state.payload.map;
  const levels = map.z.flat().filter((value) => value !== null).sort((a, b) => a - b);
  const trace = {
    type: "heatmap", x: map.time, y: map.y, z: map.z, colorscale: "Viridis",
    zmin: levels[Math.floor(levels.length * 0.5)], zmax: levels[levels.length - 1],
    colorbar: { title: { text: "dB", side: "top" }, thickness: 10, outlinewidth: 0, xpad: 4, tickfont: { size: 11 } },
    hovertemplate: "%{x:.4g} s<br>%{y:.4g} " + (map.axis === "Order" ? "× shaft speed" : "Hz") + "<br>%{z:.1f} dB<extra></extra>",
  };
  const plan = layout(state.canvas, { xaxis: axis("Time (s)"), yaxis: axis(map.axis) });
  plan.margin.r = 62;
  return show(state.canvas, [trace], plan);
}

function drawOrbit(state) {
  const orbit = state.payload.orbit, unit = plotText(orbit.unit);
  const trace = {
    type: "scatter", mode: "lines", x: orbit.x, y: orbit.y, line: { color: colour("curve"), width: 1 },
    hovertemplate: `x %{x:.4g}, y %{y:.4g} ${unit}<extra></extra>`,
  };
  // A turn begins at the dot and runs on along the line.
  const orders = (orbit.orders || []).map((one, index) => ({
    type: "scatter", mode: "lines+markers", name: plotText(one.name), x: one.x, y: one.y,
    line: { color: colour("g" + (index + 1)), width: 2 },
    marker: { size: one.x.map((_, number) => (number ? 0 : 9)), color: colour("g" + (index + 1)) },
    hovertemplate: `x %{x:.4g}, y %{y:.4g} ${unit}<extra>${plotText(one.name)}</extra>`,
  }));
  trace.name = "signal";
  const side = Math.min(state.canvas.clientWidth, 440);
  return show(state.canvas, [trace, ...orders], layout(state.canvas, {
    height: side, width: undefined,
    showlegend: orders.length > 0, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } },
    xaxis: axis(`${plotText(orbit.channels[0])} (${unit})`),
    yaxis: axis(`${plotText(orbit.channels[1])} (${unit})`, { scaleanchor: "x", scaleratio: 1 }),
  }));
}

function drawTurn(state) {
  const turn = state.payload.turn, unit = plotText(turn.unit);
  const traces = turn.traces.map((one, index) => ({
    type: "scatter", mode: "lines", name: plotText(one.name), x: expandX(one.curve), y: one.curve.y,
    line: index ? { color: colour("g" + index), width: index === 1 ? 2.4 : 1.4, dash: index === 1 ? "solid" : ["dash", "dot", "dashdot"][index - 2] }
      : { color: colour("curve"), width: 0.7 },
    hovertemplate: `%{x:.1f}°<br>%{y:.4g} ${unit}<extra>${plotText(one.name)}</extra>`,
  }));
  const plan = layout(state.canvas, {
    xaxis: axis("Shaft angle (degrees)", { dtick: 180 }), yaxis: axis(`Signal (${unit})`, { exponentformat: "power" }),
    showlegend: true, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } },
  });
  plan.margin.t = 44;
  return show(state.canvas, traces, plan);
}

function drawTrend(state) {
  const trend = state.payload.trend, series = trend.series[state.series];
  const dashes = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
  const several = series.traces.length > 1, share = series.group === "Findings";
  const labels = trend.labels.map(plotText);
  const traces = series.traces.map((one, index) => ({
    type: "scatter", mode: "lines+markers", name: plotText(one.name), x: trend.x, y: one.y, text: labels,
    line: { color: colour("g" + (index % 8)), width: 1.5, dash: dashes[index % dashes.length] }, marker: { size: 6, symbol: index },
    hovertemplate: `%{text}<br>${share ? "%{y:.0%}" : "%{y:.5g}"}<extra>${several ? plotText(one.name) : ""}</extra>`,
  }));
  const few = trend.jump && trend.x.length <= 20;
  const plan = layout(state.canvas, {
    xaxis: axis(plotText(trend.xTitle), few ? { dtick: 1 } : {}),
    yaxis: axis(share ? "Probability" : "", share ? { range: [-0.03, 1.05], tickformat: ".0%" } : { exponentformat: "power" }),
    showlegend: several || share, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } },
  });
  plan.margin.t = several || share ? (state.canvas.clientWidth < 520 ? 24 + 20 * series.traces.length : 60) : 14;
  const drawn = show(state.canvas, traces, plan);
  if (trend.jump && !state.listening) {
    state.listening = true;
    state.canvas.on("plotly_click", (event) => openFile(event.points[0].pointIndex));
  }
  return drawn;
}

const DRAW = {
  spectrum: drawSpectral, envelope: drawSpectral, waveform: drawWaveform, map: drawMap, orbit: drawOrbit, turn: drawTurn,
  trend: drawTrend,
};

function caption(state, note) {
  state.figure.querySelector("figcaption").textContent = [state.figure.dataset.caption, note].filter(Boolean).join(" ");
}
