// A chart of lines and clouds.

// Charts over one another: zoom and what is hidden is common to a group.
const groups = new Map();
const grouped = chart => {
  const key = chart.group || chart;
  if (!groups.has(key)) groups.set(key, { hidden: new Set(), builds: [], now: [], busy: false });
  return groups.get(key);
};
// Cursors go together where the abscissa is the same; a group's hints too.
const linked = chart => ({
  key: chart.group || `x:${chart.x.label}`, setSeries: false, scales: ["x", null],
  filters: { pub: type => type === "mousemove" || type === "mouseleave" },
});
const isPlotted = chart => chart.lines.length || chart.clouds.length;

const spans = (u, chart) => {
  const { ctx, bbox } = u;
  for (const s of chart.spans || []) {
    const a = Math.max(bbox.left, u.valToPos(s.from, "x", true)), b = Math.min(bbox.left + bbox.width, u.valToPos(s.to, "x", true));
    ctx.fillStyle = alpha(theme.outlier, 0.16);
    if (b > a) ctx.fillRect(a, bbox.top, Math.max(b - a, 2), bbox.height);
  }
};

const rampWords = (chart, range) => {
  const size = range[1] - range[0];
  return `${chart.shade.label} ${figure(range[0], size * 20)} \u2026 ${withUnit(range[1], size * 20, chart.shade)}`;
};
const rampEntry = (holder, chart, range) => {
  const e = make("span", "ramp"), bar = make("i", "", e);
  bar.setAttribute("aria-hidden", "true");
  e.append(rampWords(chart, range));
  const next = holder.nextElementSibling;
  (next && next.className === "legend" ? next : (() => { const box = make("div", "legend"); holder.after(box); return box; })()).append(e);
  return () => { bar.style.background = `linear-gradient(to right, ${theme.ramp.join(", ")})`; };
};

const fit = (holder, chart) => {
  const group = grouped(chart), first = !group.now.length, palette = () => chart.group ? theme.traces : theme.lines;
  const home = extent(chart), hidden = group.hidden, tip = tooltip(holder), range = chart.shade ? shades(chart) : null;
  const far = beyond(chart, home);
  if (far) make("span", "count", holder.closest("figure").querySelector("figcaption"), ` ${far} beyond the axes.`);
  let u, view = home;
  const entries = first ? [...lineEntries(chart, palette), ...bandEntries(chart, palette)] : [];
  for (const c of chart.clouds) {
    c.fitted = chart.lines.length > 0 && c.w.some(w => w !== 1);
    entries.push({ key: c.name, label: c.label || words(c.name), mark: "dot", paint: e => { e.style.background = range ? ramp(0.5) : theme.cloud; } });
    if (c.w.includes(0))
      entries.push({ key: c.name + "\u0000out", label: "outliers", mark: "ring", paint: e => { e.style.borderColor = theme.outlier; } });
  }
  const hover = () => {
    const { left } = u.cursor;
    if (left == null || left < 0 || !(chart.group || u.hovered || u.byKeys)) return tip.hide();
    const xr = u.scales.x.max - u.scales.x.min, yr = u.scales.y.max - u.scales.y.min, x = u.posToVal(left, "x");
    const rows = [[chart.x.label, chart.time ? day(x) : withUnit(x, xr, chart.x)]];
    for (const l of chart.lines) {
      if (hidden.has(l.name) || l.path) continue;
      const i = l.x.findIndex(v => v >= x);
      if (i < 1 || l.y[i] == null || l.y[i - 1] == null) continue;
      const t = (x - l.x[i - 1]) / (l.x[i] - l.x[i - 1] || 1);
      const at = a => a[i - 1] + t * (a[i] - a[i - 1]);
      rows.push([l.label, withUnit(at(l.y), yr, chart.y)]);
      for (const [low, high, key] of bandsOf(l)) {
        if (hidden.has(key) || low[i] == null || low[i - 1] == null) continue;
        const what = key === SCATTER ? "of it scatter" : l.band || "95 % interval";
        rows.push([`  ${what}`, `${figure(at(low), yr)} to ${withUnit(at(high), yr, chart.y)}`]);
      }
    }
    for (const s of chart.spans || []) if (s.from <= x && x <= s.to) rows.push([s.label]);
    const found = nearest(u, chart, hidden);
    if (found) rows.push(...told(chart, found, xr, yr));
    tip.show(u, left, rows);
  };
  const choose = () => {
    const found = nearest(u, chart, hidden);
    if (!found) return pick(null);
    const [c, i] = found;
    if (c.h && c.h[i]) location.href = c.h[i];
    else pick(c.m[i]);
  };
  const build = () => {
    const was = u && { x: { ...u.scales.x }, y: { ...u.scales.y } };
    if (u) u.destroy();
    const width = printing ? 330 : holder.clientWidth, c = columns(chart, hidden, palette());
    const height = chart.height || Math.round(Math.max(printing ? 220 : 230, Math.min(320, width * 0.62)));
    view = chart.equal ? levelled(home, width, height) : home;
    u = new uPlot({
      width, height,
      series: c.series, bands: c.bands,
      scales: { x: { time: Boolean(chart.time), auto: false, range: asked(view) }, y: { auto: false, range: (v, min, max) => min == null ? view.y : [min, max] } },
      axes: axes(chart, false), legend: { show: false }, tzDate: ts => uPlot.tzDate(new Date(ts * 1e3), "Etc/UTC"),
      cursor: {
        y: false, points: { show: false }, drag: chart.group ? { x: true, y: false } : { x: true, y: true, uni: 24 },
        sync: linked(chart),
        bind: { dblclick: () => () => { reset(u, view); return null; } },
      },
      hooks: {
        drawClear: [v => spans(v, chart)],
        drawAxes: [v => { if (!chart.time) zeroLines(v); for (const cloud of chart.clouds) drawCloud(v, cloud, hidden, range); drawPaths(v, chart, hidden, palette()); }],
        setCursor: [() => { if (u) hover(); }],
        setScale: [(v, key) => {
          if (chart.name && !chart.equal) remember(v, chart.name, view);
          if (key !== "x" || group.busy) return;
          group.busy = true;
          for (const other of group.now) {
            const o = other();
            if (o && o !== v && (o.scales.x.min !== v.scales.x.min || o.scales.x.max !== v.scales.x.max))
              o.setScale("x", { min: v.scales.x.min, max: v.scales.x.max });
          }
          group.busy = false;
        }],
      },
    }, c.data, holder);
    u.over.addEventListener("mouseenter", () => { u.hovered = true; u.byKeys = false; });
    u.over.addEventListener("mouseleave", () => { u.hovered = false; tip.hide(); });
    let down = null;
    u.over.addEventListener("mousedown", e => { down = [e.clientX, e.clientY]; });
    u.over.addEventListener("mouseup", e => { if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 4 && chart.clouds.length) choose(); });
    // a legend's click keeps the zoom; paper and a new width start afresh
    if (was && was.x.min != null && !printing && !chart.equal)
      u.batch(() => { u.setScale("x", { min: was.x.min, max: was.x.max }); u.setScale("y", { min: was.y.min, max: was.y.max }); });
    else { reset(u, view); if (!was && !printing) recall(u, chart.name); }
    holder.uplot = u; // for tests and for the curious
  };
  build();
  group.now.push(() => u);
  group.builds.push(build);
  const frame = holder.closest("figure"), title = frame.querySelector("figcaption strong")?.textContent || named(chart.y);
  saves(frame, chart.name || "chart", title, {
    csv: () => csvOf(chart), canvas: () => pictureOf(u, title),
    drawing: () => drawingOf(() => u, build, () => ({ title, key: coloured(chart, hidden, palette()), note: range && `Points: ${rampWords(chart, range)}, light to dark.` })),
  });
  legend(holder, entries, hidden, () => group.builds.forEach(f => f()));
  const tint = range ? rampEntry(holder, chart, range) : () => {};
  tint();
  holder.addEventListener("blur", () => { u.byKeys = false; tip.hide(); });
  keys(holder, () => u, () => { u.byKeys = false; tip.hide(); reset(u, view); if (chart.clouds.length) pick(null); }, choose);
  follow(holder, () => u);
  picked.redraws.push(() => u.redraw(false));
  drawn.push(() => { build(); tint(); entries.forEach(e => e.repaint && e.repaint()); });
};
