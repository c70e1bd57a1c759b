// What every chart needs: theme, numbers, extents, axes, hints, keys, legends.
// The files of this folder are one script: base, links, svg, cloud, fit, timeline, laps, main, in that order; of the
// tyre explorer base, links, svg, tyre_model, explorer.
// Before them stands KINDS, made from src/segment/manoeuvre: words, letters, sides, rest of each kind.
// Texts reach the page through textContent alone.
const store = document.getElementById("data");
if (!("DecompressionStream" in window)) {
  for (const e of document.querySelectorAll(".charts, .panels, .overlays")) {
    const p = document.createElement("p");
    p.textContent = "The charts need a browser of 2023 or later; every number is in the tables.";
    e.replaceChildren(p);
  }
  return;
}
// as src/report/charts/pack.rs writes it: base64 of zlib of JSON, columns as steps of their last decimal
const packed = Uint8Array.from(atob(store.textContent), c => c.charCodeAt(0));
const data = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).json();
const unstep = column => {
  if (!column || Array.isArray(column)) return column;
  const scale = 10 ** column.e;
  let now = 0;
  return column.d.map(step => step == null ? null : (now += step) / scale);
};
for (const chart of [...data.charts, ...data.panels])
  for (const part of [...chart.lines, ...chart.clouds])
    for (const name of ["x", "y", "lo", "hi", "scatter_lo", "scatter_hi", "w", "s"]) if (part[name]) part[name] = unstep(part[name]);
// the time line's abscissae are there once
for (const p of data.panels) for (const l of p.lines) if (!l.x.length) l.x = data.panels[0].lines[0].x;
if (data.laps)
  for (const part of [data.laps, ...data.laps.laps])
    for (const name of ["s", "x", "y", "d", "v", "roll", "ax", "ay", "used"]) if (part[name]) part[name] = unstep(part[name]);
store.figures = data; // for tests and for the curious
const root = document.documentElement;
const make = (tag, name, parent, text) => {
  const e = document.createElement(tag);
  if (name) e.className = name;
  if (text !== undefined) e.textContent = text;
  if (parent) parent.append(e);
  return e;
};
const FONT = '12px system-ui, -apple-system, "Segoe UI", "Liberation Sans", Arial, sans-serif';
let theme = {}, printing = false;
const readTheme = () => {
  const style = getComputedStyle(root);
  const get = name => style.getPropertyValue(name).trim();
  theme = {
    ink: get("--ink"), soft: get("--soft"), grid: get("--grid"), zero: get("--zero"),
    cloud: get("--cloud"), outlier: get("--outlier"),
    lines: [get("--line-1"), get("--line-2"), get("--line-3"), get("--line-4")],
    traces: [get("--ink"), get("--line-1"), get("--line-2"), get("--line-3")],
    ramp: get("--ramp").split(/\s+/),
    kind: name => get("--kind-" + String(name).replace(/[^a-z_]/g, "")) || get("--kind-other"),
  };
};
const alpha = (colour, a) => {
  const n = parseInt(colour.slice(1), 16);
  return `rgba(${n >> 16},${(n >> 8) & 255},${n & 255},${a})`;
};
const minus = text => String(text).replace(/-/g, "\u2212");
// as many decimals as the visible range needs
const figure = (value, range) => {
  if (value == null) return "\u2013";
  const decimals = Math.max(0, Math.min(8, Math.ceil(2.5 - Math.log10(range || 1))));
  return minus(value.toFixed(decimals));
};
// a colour of the ramp, 0 to 1
const ramp = share => {
  const stops = theme.ramp, at = Math.max(0, Math.min(1, share)) * (stops.length - 1), i = Math.min(stops.length - 2, Math.floor(at));
  const part = (stop, k) => parseInt(stops[stop].slice(1 + 2 * k, 3 + 2 * k), 16);
  const mix = k => Math.round(part(i, k) + (at - i) * (part(i + 1, k) - part(i, k)));
  return `#${[0, 1, 2].map(k => mix(k).toString(16).padStart(2, "0")).join("")}`;
};
const withUnit = (v, range, axis) => figure(v, range) + (axis.unit && axis.unit !== "\u00b0" && v != null ? " " : "") + (v == null ? "" : axis.unit);
const day = seconds => new Date(seconds * 1000).toISOString().replace("T", " ").slice(0, 16);
const dates = (u, splits) => splits.map(s => s == null ? null : u.scales.x.max - u.scales.x.min > 4 * 86400 ? day(s).slice(0, 10) : day(s).slice(5));
const named = axis => axis.unit ? `${axis.label}, ${axis.unit}` : axis.label;
const words = name => KINDS[name]?.words ?? String(name).replace(/_/g, " ");

// Extent of the chart: its lines and the bulk of what the fit used; what lies far off does not
// set the scale.
const extent = chart => {
  const range = () => [Infinity, -Infinity];
  const put = (r, v) => { if (v != null) { if (v < r[0]) r[0] = v; if (v > r[1]) r[1] = v; } };
  const x = range(), y = range(), allX = range(), allY = range(), band = range();
  for (const l of chart.lines) {
    l.x.forEach(v => put(x, v));
    l.y.forEach(v => put(y, v));
    l.lo.forEach(v => put(band, v));
    l.hi.forEach(v => put(band, v));
  }
  for (const c of chart.clouds) {
    const used = c.x.map((_, i) => i).filter(i => c.w[i] > 0);
    const bulk = (values, r) => {
      const sorted = (used.length ? used.map(i => values[i]) : [...values]).sort((a, b) => a - b);
      const skip = Math.floor(sorted.length / 100);
      if (sorted.length) { put(r, sorted[skip]); put(r, sorted[sorted.length - 1 - skip]); }
      values.forEach(v => put(r === x ? allX : allY, v));
    };
    bulk(c.x, x);
    bulk(c.y, y);
    for (const ends of [c.lo || [], c.hi || []]) ends.forEach(v => put(band, v));
  }
  // towards the far ones, but only so far
  const widen = (r, others, most) => {
    const size = Math.max(r[1] - r[0], 1e-9);
    const [low, high] = [r[0] - most * size, r[1] + most * size];
    for (const other of others) {
      if (other[0] > other[1]) continue;
      r[0] = Math.min(r[0], Math.max(other[0], low));
      r[1] = Math.max(r[1], Math.min(other[1], high));
    }
  };
  widen(x, [allX], 0.2);
  widen(y, [allY, band], chart.clouds.some(c => c.lo) ? 3 : chart.clouds.length ? 0.35 : 1);
  const pad = (r, share) => {
    const size = r[1] - r[0];
    const p = size > 0 ? size * share : Math.abs(r[0]) * 0.1 || 1;
    return [r[0] - p, r[1] + p];
  };
  return { x: pad(x, chart.clouds.length ? 0.03 : 0), y: pad(y, 0.05) };
};
const beyond = (chart, view) => {
  const out = (v, r) => v < r[0] || v > r[1];
  return chart.clouds.reduce((n, c) =>
    n + c.x.filter((v, i) => out(v, view.x) || out(c.y[i], view.y)).length, 0);
};

// The bands of a line: the whole interval lightly, what the scatter between manoeuvres has in it darker upon it.
const BAND = "\u0000band", SCATTER = "\u0000scatter", LIGHT = 0.16, DARK = 0.3;
const bandsOf = line => [
  ...(line.lo.length ? [[line.lo, line.hi, BAND, line.scatter_lo ? LIGHT : 0.2]] : []),
  ...(line.scatter_lo ? [[line.scatter_lo, line.scatter_hi, SCATTER, DARK]] : []),
];
// What was not ridden is dashed: ordinates of the solid and of the dashed part, which reaches to its neighbours.
const partsOf = line => {
  const off = line.x.map(x => (line.unridden || []).some(([from, to]) => from < x && x < to));
  if (!off.includes(true)) return [line.y];
  return [line.y.map((y, i) => off[i] ? null : y), line.y.map((y, i) => off[i - 1] || off[i] || off[i + 1] ? y : null)];
};
// Lines on their common abscissa: one column per line, one of its dashed part, then its lower and upper edge.
const columns = (chart, hidden, palette) => {
  const tables = [], series = [{}], bands = [];
  // of a group the first colour, what was measured, is wide: it shows beside a line upon it
  chart.lines.forEach((line, i) => {
    if (line.path) return; // uPlot wants rising abscissae: drawn beside the points
    const colour = palette[(line.colour ?? i) % palette.length];
    const show = !hidden.has(line.name), parts = partsOf(line);
    const solid = { label: line.name, show, stroke: colour, width: chart.clouds.length ? 2 : chart.group && line.colour === 0 ? 3 : 1.5, pxAlign: 0, points: { show: false } };
    series.push(solid);
    if (parts.length > 1) series.push({ ...solid, dash: [6, 4] });
    const table = [line.x, ...parts];
    for (const [low, high, key, share] of bandsOf(line)) {
      const edge = series.length;
      table.push(low, high);
      for (let k = 0; k < 2; k++)
        series.push({ label: "", show: show && !hidden.has(key), width: 0, stroke: alpha(colour, 0.01), points: { show: false } });
      bands.push({ series: [edge + 1, edge], fill: alpha(colour, share) });
    }
    tables.push(table);
  });
  if (!tables.length) return { series: [{}, { show: false }], bands, data: [[0, 1], [null, null]] };
  return { series, bands, data: tables.length > 1 ? uPlot.join(tables) : tables[0] };
};

const axes = (chart, compact, bare) => {
  const common = {
    stroke: theme.soft, font: FONT, labelFont: FONT,
    grid: { stroke: theme.grid, width: 1 }, ticks: { stroke: theme.grid, width: 1, size: 4 },
    values: (u, splits) => splits.map(v => v == null ? null : minus(+v.toPrecision(10))),
  };
  return [
    { ...common, ...(chart.time ? { values: (u, splits) => dates(u, splits) } : {}), size: bare ? 6 : 30, gap: 4, label: bare ? undefined : named(chart.x), labelSize: 18, space: chart.time ? 90 : 60, ...(bare ? { values: () => [] } : {}) },
    { ...common, size: 52, gap: 4, label: compact ? undefined : named(chart.y), labelSize: 18, space: compact ? 17 : chart.height ? 20 : 36 },
  ];
};

// Axes of one scale: the shorter range is widened.
const levelled = (view, width, height) => {
  const size = r => r[1] - r[0], wide = r => (r[0] + r[1]) / 2;
  const per = Math.max(size(view.x) / (width - 62), size(view.y) / (height - 60));
  const about = (r, length) => [wide(r) - per * length / 2, wide(r) + per * length / 2];
  return { x: about(view.x, width - 62), y: about(view.y, height - 60) };
};

const zeroLines = u => {
  const { ctx, bbox } = u, px = devicePixelRatio || 1;
  ctx.save();
  ctx.strokeStyle = theme.zero;
  ctx.lineWidth = px;
  ctx.beginPath();
  const x = u.valToPos(0, "x", true), y = u.valToPos(0, "y", true);
  if (x > bbox.left && x < bbox.left + bbox.width) { ctx.moveTo(x, bbox.top); ctx.lineTo(x, bbox.top + bbox.height); }
  if (y > bbox.top && y < bbox.top + bbox.height) { ctx.moveTo(bbox.left, y); ctx.lineTo(bbox.left + bbox.width, y); }
  ctx.stroke();
  ctx.restore();
};

// What is under the cursor, for the eye; for the ear too, once keys move it.
const spoken = make("p", "unseen", document.body);
spoken.setAttribute("aria-live", "polite");
const tooltip = holder => {
  const tip = make("div", "tip", holder);
  tip.hidden = true;
  return {
    hide: () => { tip.hidden = true; },
    show: (u, left, rows) => {
      tip.replaceChildren(...rows.map(([label, value]) => {
        const p = make("p");
        make("span", "", p, label);
        if (value !== undefined) make("b", "", p, value);
        return p;
      }));
      tip.hidden = false;
      if (document.activeElement === holder) spoken.textContent = rows.map(r => r.join(" ")).join("; ");
      const over = u.over.getBoundingClientRect(), own = holder.getBoundingClientRect();
      const at = over.left - own.left + left;
      tip.style.left = `${Math.max(0, Math.min(at > own.width / 2 ? at - tip.offsetWidth - 14 : at + 14, own.width - tip.offsetWidth))}px`;
      // away from the pointer: at the foot when it is in the upper half of a tall chart
      const tall = own.height > 200 && u.cursor.top < u.over.clientHeight / 2;
      tip.style.top = tall ? `${Math.max(6, own.height - tip.offsetHeight - 54)}px` : "6px";
    },
  };
};

// uPlot sends every x range through this function, a zoom's too: what is asked for stands.
const asked = view => (u, min, max) => min == null ? view.x : [min, max];
const reset = (u, view) => u.batch(() => {
  u.setScale("x", { min: view.x[0], max: view.x[1] });
  u.setScale("y", { min: view.y[0], max: view.y[1] });
});
const zoom = (u, factor) => {
  const { min, max } = u.scales.x, mid = (min + max) / 2, half = (max - min) / 2 * factor;
  u.setScale("x", { min: mid - half, max: mid + half });
};
// Arrow keys walk, + and - zoom, 0 or Escape resets, Enter chooses what is under the cursor.
const keys = (holder, current, home, choose) => holder.addEventListener("keydown", event => {
  const u = current(), width = u.over.clientWidth;
  const walk = by => {
    const left = Math.max(0, Math.min(width, (u.cursor.left >= 0 ? u.cursor.left : width / 2) + by * width));
    u.byKeys = true;
    u.setCursor({ left, top: u.over.clientHeight / 2 });
  };
  const step = event.shiftKey ? 0.1 : 0.01;
  const actions = {
    ArrowLeft: () => walk(-step), ArrowRight: () => walk(step),
    "+": () => zoom(u, 0.7), "=": () => zoom(u, 0.7), "-": () => zoom(u, 1.4),
    "0": home, Escape: home, Enter: choose,
  };
  if (event.target !== holder || event.ctrlKey || event.metaKey || event.altKey || !actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
});

// A chart is as wide as its place on the page.
const follow = (holder, current) => new ResizeObserver(() => {
  const u = current(), width = holder.clientWidth;
  if (!printing && width > 0 && Math.abs(width - u.width) >= 1) u.setSize({ width, height: u.height });
}).observe(holder);

const legend = (holder, entries, hidden, changed) => {
  if (entries.length < 2) return;
  const box = make("div", "legend");
  holder.after(box);
  for (const entry of entries) {
    const button = make("button", "", box);
    button.type = "button";
    const mark = make("i", entry.mark, button);
    mark.setAttribute("aria-hidden", "true");
    entry.paint(mark);
    button.append(entry.label);
    const tell = () => button.setAttribute("aria-pressed", String(!hidden.has(entry.key)));
    tell();
    button.addEventListener("click", () => {
      if (!hidden.delete(entry.key)) hidden.add(entry.key);
      tell();
      changed();
    });
    entry.repaint = () => entry.paint(mark);
  }
  return entries;
};
// The shown lines of a chart with their colours.
const coloured = (chart, hidden, palette) => chart.lines.flatMap((l, i) => hidden.has(l.name) ? [] : [[l.label, palette[(l.colour ?? i) % palette.length]]]);
const lineEntries = (chart, palette) => chart.lines.map((l, i) => ({
  key: l.name, label: l.label, mark: "line",
  paint: e => { e.style.background = palette()[(l.colour ?? i) % palette().length]; },
}));
// which band is which, where a line has two
const bandEntries = (chart, palette) => {
  const found = chart.lines.findIndex(l => l.scatter_lo);
  if (found < 0) return [];
  const l = chart.lines[found], tone = share => e => { e.style.background = alpha(palette()[(l.colour ?? found) % palette().length], share); };
  return [
    { key: BAND, label: "95 % interval", mark: "band", paint: tone(LIGHT + 0.09) },
    { key: SCATTER, label: "of it scatter between manoeuvres", mark: "band", paint: tone(LIGHT + DARK) },
  ];
};

const drawn = []; // every chart's own redraw, for a change of theme or width
