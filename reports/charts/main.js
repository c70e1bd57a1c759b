// Starts: a chart is drawn when it comes near the window, all of them for paper.
const swatches = () => {
  for (const e of document.querySelectorAll(".swatch")) {
    e.style.background = theme.kind(e.dataset.kind);
    if (e.closest(".kinds")) e.textContent = KINDS[e.dataset.kind]?.letter || "";
  }
};
readTheme();
swatches();

const waiting = new Map();
const start = holder => {
  const draw = waiting.get(holder);
  if (!draw) return;
  waiting.delete(holder);
  watcher.unobserve(holder);
  holder.style.minHeight = "";
  draw();
};
const watcher = new IntersectionObserver(found => found.forEach(e => { if (e.isIntersecting) start(e.target); }), { rootMargin: "400px 0px" });
const wait = (holder, chart, draw) => {
  // of a group all or none: its zoom is common
  if (chart.group) return draw();
  holder.style.minHeight = `${chart.height || 230}px`;
  waiting.set(holder, draw);
  watcher.observe(holder);
};
for (const e of document.querySelectorAll("[data-chart]")) {
  const chart = data.charts[+e.dataset.chart];
  if (isPlotted(chart)) wait(e, chart, () => fit(e, chart));
}
// the panels are zoomed together: all of them or none
const lane = document.querySelector(".panels");
if (lane && data.panels.length)
  wait(lane, { height: 120 * data.panels.length }, () =>
    document.querySelectorAll("[data-panel]").forEach((e, i) => panel(e, data.panels[+e.dataset.panel], i)));

if (track && document.getElementById("laps")) lapCharts();

for (const b of document.querySelectorAll("button[data-manoeuvre]"))
  b.addEventListener("click", () => pick(+b.dataset.manoeuvre));
if (note) note.querySelector("button").addEventListener("click", () => pick(null));
addEventListener("keydown", e => { if (e.key === "Escape" && picked.id != null) pick(null); });

// what the address asks for is drawn and brought into view
const linkedTo = (address.get("zoom") || "").split(",")[0];
const asks = linkedTo && (linkedTo === "time" ? lane : [...document.querySelectorAll("[data-chart]")].find(e => data.charts[+e.dataset.chart].name === linkedTo));
if (asks) {
  for (let e = asks; e; e = e.parentElement) if (e.tagName === "DETAILS") e.open = true;
  start(asks);
  asks.scrollIntoView({ block: "center" });
}
const wanted = Number(address.get("manoeuvre"));
if (address.get("manoeuvre") != null && segments.has(wanted)) pick(wanted);

const redraw = () => { readTheme(); hatches.clear(); swatches(); drawn.forEach(f => f()); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("beforeprint", () => {
  document.querySelectorAll("details.all").forEach(e => { e.open = true; });
  printing = true;
  root.dataset.print = "";
  readTheme();
  [...waiting.keys()].forEach(start);
  redraw();
});
addEventListener("afterprint", () => { printing = false; delete root.dataset.print; redraw(); });
