// The time line: panels over one another with the segments shaded.
const hatches = new Map();
const hatch = colour => {
  if (!hatches.has(colour)) {
    const tile = document.createElement("canvas"), px = Math.ceil(devicePixelRatio || 1), n = 6 * px;
    tile.width = tile.height = n;
    const ctx = tile.getContext("2d");
    ctx.strokeStyle = alpha(colour, 0.5);
    ctx.lineWidth = px;
    ctx.beginPath();
    for (const d of [-n, 0, n]) { ctx.moveTo(d, n); ctx.lineTo(d + n, 0); }
    ctx.stroke();
    // a pattern does not say what it is made of, which a drawing has to know
    hatches.set(colour, Object.assign(ctx.createPattern(tile, "repeat"), { colour }));
  }
  return hatches.get(colour);
};
const letter = s => {
  const kind = KINDS[s.kind];
  return !kind ? "" : kind.sides ? kind.sides[s.direction] || "" : kind.letter;
};
const shade = (u, lane) => {
  const { ctx, bbox } = u, px = devicePixelRatio || 1;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const s of data.segments) {
    if (KINDS[s.kind]?.rest && !s.used) continue;
    const a = u.valToPos(s.start, "x", true), b = u.valToPos(s.end, "x", true);
    if (b < bbox.left || a > bbox.left + bbox.width) continue;
    const colour = theme.kind(s.kind), w = Math.max(b - a, px);
    const strip = KINDS[s.kind]?.strip ? 5 * px : bbox.height; // overlaps the others: a strip below them
    ctx.fillStyle = KINDS[s.kind]?.strip ? colour : s.used ? alpha(colour, 0.22) : hatch(colour);
    ctx.fillRect(a, bbox.top + bbox.height - strip, w, strip);
    if (s.id === picked.id) {
      ctx.strokeStyle = theme.ink;
      ctx.lineWidth = 2 * px;
      ctx.strokeRect(a, bbox.top, w, bbox.height);
    }
    if (!lane || KINDS[s.kind]?.strip) continue;
    ctx.fillStyle = alpha(colour, s.used ? 1 : 0.35);
    ctx.fillRect(a, bbox.top, w, 14 * px);
    const text = letter(s);
    ctx.font = `600 ${10 * px}px system-ui, sans-serif`;
    if (text && ctx.measureText(text).width + 4 * px < w) {
      ctx.fillStyle = s.used ? "#fff" : theme.ink;
      ctx.textAlign = "center";
      ctx.textBaseline = "middle";
      ctx.fillText(text, a + w / 2, bbox.top + 7.5 * px);
    }
  }
  ctx.restore();
};

const panels = [];
const timeRange = () => {
  let min = Infinity, max = -Infinity;
  for (const p of data.panels) for (const l of p.lines) { min = Math.min(min, l.x[0]); max = Math.max(max, l.x[l.x.length - 1]); }
  for (const s of data.segments) max = Math.max(max, s.end);
  return max > min ? [min, max] : [0, 1];
};
const valueAt = (line, t) => {
  let lo = 0, hi = line.x.length - 1;
  while (hi - lo > 1) { const mid = (lo + hi) >> 1; if (line.x[mid] <= t) lo = mid; else hi = mid; }
  return line.y[Math.abs(line.x[lo] - t) <= Math.abs(line.x[hi] - t) ? lo : hi];
};
const panel = (holder, chart, index) => {
  const view = extent(chart), hidden = new Set(), tip = tooltip(holder);
  const last = index === data.panels.length - 1;
  view.x = timeRange();
  if (index === 0) view.y[1] += (view.y[1] - view.y[0]) * 0.16; // room for the lane of letters
  let u, busy = false;
  const hover = () => {
    const { left } = u.cursor;
    if (left == null || left < 0 || !u.hovered) return tip.hide();
    const t = u.posToVal(left, "x"), rows = [["time", `${t.toFixed(1)} s`]];
    for (const p of data.panels) for (const l of p.lines) {
      const r = Math.max(...l.y) - Math.min(...l.y);
      rows.push([l.label, figure(valueAt(l, t), r || 1) + (p.y.unit ? (p.y.unit === "°" ? "" : " ") + p.y.unit : "")]);
    }
    for (const s of data.segments.filter(v => v.start <= t && t < v.end)) {
      rows.push([`${words(s.kind)}${s.direction ? " " + s.direction : ""}`, `no. ${s.id}`]);
      if (s.quality != null) rows.push(["  quality", String(s.quality)]);
      rows.push([s.used ? "  used" : "  not used" + (s.reason ? ": " + s.reason : "")]);
    }
    tip.show(u, left, rows);
  };
  const home = () => { u.hovered = false; tip.hide(); reset(u, view); };
  const choose = () => {
    const t = u.posToVal(u.cursor.left, "x"), s = data.segments.find(v => v.start <= t && t < v.end);
    pick(s ? s.id : null);
  };
  const build = () => {
    if (u) u.destroy();
    const width = printing ? 680 : holder.clientWidth, c = columns(chart, hidden, theme.traces);
    u = new uPlot({
      width, height: 92 + (index === 0 ? 26 : 0) + (last ? 42 : 0), series: c.series, bands: c.bands,
      scales: { x: { time: false, auto: false, range: asked(view) }, y: { auto: false, range: view.y } },
      axes: axes(chart, true, !last), legend: { show: false },
      cursor: {
        y: false, points: { show: false }, drag: { x: true, y: false },
        sync: { key: "x:time", setSeries: false, scales: ["x", null], filters: { pub: type => type === "mousemove" || type === "mouseleave" } },
        bind: { dblclick: () => () => { home(); return null; } },
      },
      hooks: {
        drawClear: [v => shade(v, index === 0)],
        drawAxes: [zeroLines],
        setCursor: [() => { if (u) hover(); }],
        setScale: [(v, key) => {
          if (index === 0) remember(v, "time", view);
          if (key !== "x" || busy) return;
          busy = true;
          for (const other of panels) {
            const o = other();
            if (o && o !== v && (o.scales.x.min !== v.scales.x.min || o.scales.x.max !== v.scales.x.max))
              o.setScale("x", { min: v.scales.x.min, max: v.scales.x.max });
          }
          busy = false;
        }],
      },
    }, c.data, holder);
    u.over.addEventListener("mouseenter", () => { u.hovered = true; });
    u.over.addEventListener("mouseleave", () => { u.hovered = false; tip.hide(); });
    let down = null;
    u.over.addEventListener("mousedown", e => { down = e.clientX; });
    u.over.addEventListener("mouseup", e => { if (down != null && Math.abs(e.clientX - down) < 4) choose(); });
    holder.uplot = u;
    home();
  };
  build();
  panels.push(() => u);
  if (last && panels.length) recall(panels[0](), "time");
  const title = named(chart.y);
  saves(holder.closest("figure"), chart.name || "time", title, {
    csv: () => csvOf(chart), canvas: () => pictureOf(u, title),
    drawing: () => drawingOf(() => u, build, () => ({ title, key: coloured(chart, hidden, theme.traces) })),
  });
  const entries = lineEntries(chart, () => theme.traces);
  legend(holder, entries, hidden, build);
  keys(holder, () => { u.hovered = true; return u; }, home, choose);
  picked.redraws.push(() => u.redraw(false));
  holder.addEventListener("blur", () => { u.hovered = false; tip.hide(); });
  follow(holder, () => u);
  drawn.push(() => { build(); entries.forEach(e => e.repaint && e.repaint()); });
};
