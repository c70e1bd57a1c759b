// The page's address is a link to what is shown (zoom, manoeuvre, lap), and each chart gives its data and its picture.
const address = (() => {
  const now = new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : "");
  const put = (name, value) => {
    if (value == null ? !now.has(name) : now.get(name) === value) return;
    if (value == null) now.delete(name); else now.set(name, value);
    const text = now.toString();
    history.replaceState(null, "", location.href.split("#")[0] + (text ? `#${text}` : ""));
  };
  return { get: name => now.get(name), put };
})();
// a link put into the address of a page that is open; what the page itself puts there calls nothing
addEventListener("hashchange", () => { if (document.getElementById("explorer") == null && location.hash.includes("=")) location.reload(); });
const ends = scale => [scale.min, scale.max].map(v => +v.toPrecision(7));
// keeps the zoom of a chart in the address; a chart at home has none
const remember = (u, name, view) => {
  clearTimeout(u.remembering);
  u.remembering = setTimeout(() => {
    if (printing || u.scales.x.min == null) return;
    const x = ends(u.scales.x), y = ends(u.scales.y), near = (a, b, size) => Math.abs(a - b) <= 1e-5 * size;
    const same = (now, then) => now.every((v, i) => near(v, then[i], then[1] - then[0]));
    if (!same(x, view.x) || !same(y, view.y)) address.put("zoom", [name, ...x, ...y].join(","));
    else if ((address.get("zoom") || "").split(",")[0] === name) address.put("zoom", null);
  }, 150);
};
const recall = (u, name) => {
  const [of, ...parts] = (address.get("zoom") || "").split(","), v = parts.map(Number);
  if (of !== name || v.length !== 4 || !v.every(Number.isFinite) || !(v[1] > v[0] && v[3] > v[2])) return;
  u.batch(() => {
    u.setScale("x", { min: v[0], max: v[1] });
    u.setScale("y", { min: v[2], max: v[3] });
  });
};

const save = (blob, name) => {
  const link = make("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};
const cell = value => value == null ? "" : /[",\n]/.test(value) ? `"${String(value).replace(/"/g, '""')}"` : String(value);
const rowsOf = rows => rows.map(row => row.map(cell).join(",")).join("\n") + "\n";
const headed = axis => axis.unit ? `${axis.label} (${axis.unit === "\u00b0" ? "deg" : axis.unit})` : axis.label;
const csvOf = chart => rowsOf([
  ["series", chart.time ? "time (UTC)" : headed(chart.x), headed(chart.y), "low", "high", "weight", "manoeuvre"],
  ...chart.lines.flatMap(l => l.x.map((x, i) => [l.label, chart.time ? day(x) : x, l.y[i], l.lo[i], l.hi[i], null, null])),
  ...chart.clouds.flatMap(c => c.x.map((x, i) =>
    [c.t ? c.t[i] : c.label || c.name, chart.time ? day(x) : x, c.y[i], c.lo && c.lo[i], c.hi && c.hi[i], c.w[i], c.m[i]])),
]);
// the chart on the page's paper, under its title
const pictureOf = (u, title) => {
  const from = u.ctx.canvas, px = devicePixelRatio || 1, head = title ? 26 * px : 0, to = make("canvas"), k = to.getContext("2d");
  [to.width, to.height] = [from.width, from.height + head];
  k.fillStyle = getComputedStyle(document.body).backgroundColor;
  k.fillRect(0, 0, to.width, to.height);
  k.fillStyle = theme.ink;
  k.font = `600 ${13 * px}px system-ui, sans-serif`;
  k.fillText(title, 8 * px, 18 * px);
  k.drawImage(from, 0, head);
  return to;
};
// Buttons for a chart's data, its picture and its drawing, as far as there are functions that give them.
const saves = (frame, name, title, { csv, canvas, drawing }) => {
  const box = make("span", "saves screen", frame.querySelector("figcaption"));
  const button = (text, what, act) => {
    const b = make("button", "", box, text);
    b.type = "button";
    b.setAttribute("aria-label", `${what} of ${title}`);
    b.addEventListener("click", act);
  };
  if (csv) button("CSV", "data", () => save(new Blob([csv()], { type: "text/csv" }), `${name}.csv`));
  if (canvas) button("PNG", "picture", () => canvas().toBlob(blob => save(blob, `${name}.png`)));
  if (drawing) button("SVG", "drawing", () => save(new Blob([drawing()], { type: "image/svg+xml" }), `${name}.svg`));
  Object.assign(box, { csv, drawing }); // for tests and for the curious
};
