// Connects the page's switches, tables and sections with the figures.

const drawnFigures = [];
const payloads = {};

function payloadOf(article) {
  const name = article.dataset.payload;
  if (!(name in payloads)) payloads[name] = JSON.parse(document.getElementById("data-" + name).textContent);
  return payloads[name];
}

function startFigure(figure, payload) {
  const state = {
    figure: figure, kind: figure.dataset.plot, canvas: figure.querySelector(".canvas"), payload: payload,
    channel: 0, series: 0, scale: "log", axis: "hz", zoom: "near", range: null, listening: false,
    groups: new Set((payload.cursors || []).map((group, index) => (group.on ? index : -1)).filter((index) => index >= 0)),
  };
  const redraw = () => DRAW[state.kind](state);
  const follow = (role, apply) => {
    const select = figure.querySelector(`select[data-role="${role}"]`);
    // A browser may restore an earlier choice when it reloads the page.
    if (select) { apply(select.value); select.addEventListener("change", () => { apply(select.value); redraw(); }); }
  };
  follow("channel", (value) => { state.channel = Number(value); });
  follow("series", (value) => { state.series = Number(value); });
  follow("scale", (value) => { state.scale = value; });
  follow("axis", (value) => { state.axis = value; });
  figure.querySelectorAll("input[data-group]").forEach((box) => {
    const index = Number(box.dataset.group);
    const apply = () => state.groups[box.checked ? "add" : "delete"](index);
    apply();
    box.addEventListener("change", () => { apply(); keepRange(state, box.checked ? payload.cursors[index].items : []); redraw(); });
  });
  figure.querySelectorAll("button[data-zoom]").forEach((button) => {
    button.addEventListener("click", () => { state.zoom = button.dataset.zoom; state.range = null; redraw(); });
  });
  figure.querySelector('[data-role="save"]').addEventListener("click", () => {
    const name = figure.querySelector(".head").firstElementChild.textContent.replace(/[^\w-]+/g, "_");
    Plotly.downloadImage(state.canvas, { format: "png", scale: 2, filename: name });
  });
  drawnFigures.push({ state: state, redraw: redraw });
  redraw();
}

// Switching cursors must not move the picture under the reader's eyes, unless the new ones would be out of sight.
function keepRange(state, added) {
  const plan = state.canvas._fullLayout;
  const back = state.axis === "order" && state.payload.speedHz ? state.payload.speedHz : 1;
  if (!plan || !plan.xaxis) return;
  const [low, high] = plan.xaxis.range.map((value) => value * back);
  const hidden = added.length > 0 && !added.some((item) => item[1] >= low && item[1] <= high);
  state.range = hidden ? null : [low, high];
  if (hidden) state.zoom = "near";
}

function startArticle(article) {
  if (article.dataset.started) return;
  article.dataset.started = "yes";
  const payload = payloadOf(article);
  const waiting = [];
  for (const figure of article.querySelectorAll("figure.plot")) {
    const fold = figure.closest("details.fold");
    if (!fold || fold.open) waiting.push(figure);
    else fold.addEventListener("toggle", () => startFigure(figure, payload), { once: true });
  }
  // One figure a turn, so that a phone shows the first while it draws the others.
  const next = () => {
    const figure = waiting.shift();
    if (!figure) { article.dataset.ready = "yes"; return; }
    startFigure(figure, payload);
    setTimeout(next, 0);
  };
  next();
}

function openFile(index) {
  const section = document.getElementById("file-" + index);
  if (!section) return;
  section.open = true;
  section.scrollIntoView({ block: "start" });
  section.querySelector("summary").focus({ preventScroll: true });
}

function openFromAddress() {
  const match = /^#file-(\d+)$/.exec(location.hash);
  if (match) openFile(Number(match[1]));
}

function sortKey(row, column) {
  const cell = row.cells[column];
  if (cell.dataset.v === undefined) return cell.textContent.trim().toLowerCase();
  if (cell.dataset.v === "") return null;
  const value = Number(cell.dataset.v);
  return Number.isNaN(value) ? cell.dataset.v : value;
}

function sortTable(table, column) {
  const head = table.tHead.rows[0].cells[column];
  const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
  const rows = Array.from(table.tBodies[0].rows, (row) => ({ row: row, key: sortKey(row, column) }));
  rows.sort((a, b) => {
    if (a.key === null || b.key === null) return (a.key === null) - (b.key === null);
    return sign * (a.key < b.key ? -1 : a.key > b.key ? 1 : 0);
  });
  table.tBodies[0].append(...rows.map((entry) => entry.row));
}

function redrawAll() {
  drawnFigures.forEach((figure) => { if (figure.state.canvas.clientWidth) figure.redraw(); });
}

document.querySelectorAll("table.sortable").forEach((table) => {
  table.querySelectorAll("thead button").forEach((button, column) => button.addEventListener("click", () => sortTable(table, column)));
});
document.querySelectorAll(".file").forEach((article) => {
  if (article.tagName !== "DETAILS") { startArticle(article); return; }
  article.addEventListener("toggle", () => { if (article.open) startArticle(article); });
});
document.querySelectorAll('a[href^="#file-"]').forEach((link) => link.addEventListener("click", (event) => {
  event.preventDefault();
  history.replaceState(null, "", link.getAttribute("href"));
  openFromAddress();
}));
window.addEventListener("hashchange", openFromAddress);
openFromAddress();

window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
let resizing = 0;
window.addEventListener("resize", () => { clearTimeout(resizing); resizing = setTimeout(redrawAll, 200); });
window.addEventListener("beforeprint", () => { document.documentElement.dataset.print = "yes"; redrawAll(); });
window.addEventListener("afterprint", () => { delete document.documentElement.dataset.print; redrawAll(); });
