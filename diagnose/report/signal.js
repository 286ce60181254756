// Maps and curves of the pages of `rotorwise orders`, `envelope` and `sidebands`. Helpers: plots.js.

const MAP_SPAN_DB = 60;

function drawHeat(state) {
  const all = state.payload[state.kind], map = all.channels[state.channel], unit = plotText(all.unit);
  const values = map.z.flat().filter((value) => value !== null);
  const top = highest(values, 1);
  const low = all.unit === "dB" ? Math.max(top - MAP_SPAN_DB, values.reduce((a, b) => Math.min(a, b), top)) : 0;
  const trace = {
    type: "heatmap", x: map.x, y: map.y, z: map.z, colorscale: "Viridis", zmin: low, zmax: top > low ? top : low + 1,
    colorbar: { title: { text: unit, side: "top" }, thickness: 10, outlinewidth: 0, xpad: 4, tickfont: { size: 11 } },
    hovertemplate: `${plotText(all.x)} %{x:.5g}<br>${plotText(all.y)} %{y:.4g}<br>%{z:.3g} ${unit}<extra></extra>`,
  };
  const ticks = all.ticks ? { tickvals: all.ticks[0], ticktext: all.ticks[1] } : {};
  const plan = layout(state.canvas, { xaxis: axis(plotText(all.x)), yaxis: axis(plotText(all.y), ticks) });
  plan.margin.r = 62;
  plan.margin.t = 22;
  caption(state, map.note || "");
  return show(state.canvas, [trace], plan);
}

function drawGraph(state) {
  const graph = state.payload[state.kind][state.series];
  const traces = graph.traces.map((one, index) => ({
    type: "scatter", mode: one.text ? "markers" : one.marked ? "lines+markers" : "lines", name: plotText(one.name), x: one.curve ? expandX(one.curve) : one.x,
    y: one.curve ? one.curve.y : one.y, connectgaps: false,
    line: { color: colour("g" + (index % 8)), width: 1.4 }, text: one.text ? one.text.map(plotText) : undefined,
    marker: one.text ? { size: 9, symbol: "circle-open" } : { size: 5, symbol: index },
    hovertemplate: `${one.text ? "%{text}<br>" : ""}%{x:.5g}, %{y:.4g}<extra>${plotText(one.name)}</extra>`,
  }));
  const several = traces.length > 1;
  const plan = layout(state.canvas, {
    xaxis: axis(plotText(graph.x)),
    yaxis: axis(plotText(graph.y), Object.assign({ exponentformat: "power" }, graph.range ? { range: graph.range } : { rangemode: "tozero" })),
    showlegend: several, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } },
  });
  plan.margin.t = several ? 44 : 14;
  caption(state, graph.note || "");
  return show(state.canvas, traces, plan);
}

for (let number = 1; number <= 6; number += 1) {
  DRAW["heat-" + number] = drawHeat;
  DRAW["graph-" + number] = drawGraph;
}
