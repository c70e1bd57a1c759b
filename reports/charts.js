// Draws the charts of a session's page or its diagnosis from the JSON in #data, with uPlot.
// Texts reach the page through textContent alone.
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("data").textContent);
  const root = document.documentElement;
  const make = (tag, name, parent, text) => {
    const e = document.createElement(tag);
    if (name) e.className = name;
    if (text !== undefined) e.textContent = text;
    if (parent) parent.append(e);
    return e;
  };
  const FONT = '12px system-ui, -apple-system, "Segoe UI", "Liberation Sans", Arial, sans-serif';
  const LETTERS = {
    coasting: "C", front_braking: "F", rear_braking: "R", combined_braking: "FR",
    driving: "D", cornering: "\u21b6\u21b7", airborne: "A", whoops: "W",
  };
  let theme = {}, printing = false;
  const readTheme = () => {
    const style = getComputedStyle(root);
    const get = name => style.getPropertyValue(name).trim();
    theme = {
      ink: get("--ink"), soft: get("--soft"), grid: get("--grid"), zero: get("--zero"),
      cloud: get("--cloud"), outlier: get("--outlier"),
      lines: [get("--line-1"), get("--line-2"), get("--line-3"), get("--line-4")],
      traces: [get("--ink"), get("--line-1"), get("--line-2"), get("--line-3")],
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
  const named = axis => axis.unit ? `${axis.label}, ${axis.unit}` : axis.label;
  const words = name => String(name).replace(/_/g, " ");

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
    widen(y, [allY, band], chart.clouds.length ? 0.35 : 1);
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

  // Lines on their common abscissa: one column per line, then its lower and upper edge.
  const columns = (chart, hidden, palette) => {
    const tables = [], series = [{}], bands = [];
    // of a group the first colour, what was measured, is wide: it shows beside a line upon it
    chart.lines.forEach((line, i) => {
      const colour = palette[(line.colour ?? i) % palette.length];
      const first = series.length;
      const show = !hidden.has(line.name);
      series.push({ label: line.name, show, stroke: colour, width: chart.clouds.length ? 2 : chart.group && line.colour === 0 ? 3 : 1.5, pxAlign: 0, points: { show: false } });
      const table = [line.x, line.y];
      if (line.lo.length) {
        table.push(line.lo, line.hi);
        for (let k = 0; k < 2; k++)
          series.push({ label: "", show, width: 0, stroke: alpha(colour, 0.01), points: { show: false } });
        bands.push({ series: [first + 2, first + 1], fill: alpha(colour, 0.2) });
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
      { ...common, size: bare ? 6 : 30, gap: 4, label: bare ? undefined : named(chart.x), labelSize: 18, space: 60, ...(bare ? { values: () => [] } : {}) },
      { ...common, size: 52, gap: 4, label: compact ? undefined : named(chart.y), labelSize: 18, space: compact ? 17 : chart.height ? 20 : 36 },
    ];
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

  const drawCloud = (u, cloud, hidden) => {
    const { ctx, bbox } = u, px = devicePixelRatio || 1, r = 2 * px;
    const dense = Math.min(1, Math.max(0.3, 500 / cloud.x.length));
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (let i = 0; i < cloud.x.length; i++) {
      const out = cloud.w[i] === 0;
      if (hidden.has(out ? cloud.name + "\u0000out" : cloud.name)) continue;
      const x = u.valToPos(cloud.x[i], "x", true), y = u.valToPos(cloud.y[i], "y", true);
      ctx.beginPath();
      ctx.arc(x, y, r, 0, 2 * Math.PI);
      if (out) {
        ctx.strokeStyle = alpha(theme.outlier, 0.55);
        ctx.lineWidth = px;
        ctx.stroke();
      } else {
        ctx.fillStyle = alpha(theme.cloud, (0.2 + 0.65 * cloud.w[i]) * dense);
        ctx.fill();
      }
    }
    ctx.restore();
  };

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
  // Arrow keys walk, + and - zoom, 0 or Escape resets.
  const keys = (holder, current, home) => holder.addEventListener("keydown", event => {
    const u = current(), width = u.over.clientWidth;
    const walk = by => {
      const left = Math.max(0, Math.min(width, (u.cursor.left >= 0 ? u.cursor.left : width / 2) + by * width));
      u.setCursor({ left, top: u.over.clientHeight / 2 });
    };
    const step = event.shiftKey ? 0.1 : 0.01;
    const actions = {
      ArrowLeft: () => walk(-step), ArrowRight: () => walk(step),
      "+": () => zoom(u, 0.7), "=": () => zoom(u, 0.7), "-": () => zoom(u, 1.4),
      "0": home, Escape: home,
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
  const lineEntries = (chart, palette) => chart.lines.map((l, i) => ({
    key: l.name, label: l.label, mark: "line",
    paint: e => { e.style.background = palette()[(l.colour ?? i) % palette().length]; },
  }));

  const kinds = new Map(data.segments.map(s => [s.id, s]));
  const drawn = []; // every chart's own redraw, for a change of theme or width

  // Charts over one another: zoom and what is hidden is common to a group.
  const groups = new Map();
  const grouped = chart => {
    const key = chart.group || chart;
    if (!groups.has(key)) groups.set(key, { hidden: new Set(), builds: [], now: [], busy: false });
    return groups.get(key);
  };
  const fit = (holder, chart) => {
    const group = grouped(chart), first = !group.now.length, palette = () => chart.group ? theme.traces : theme.lines;
    const view = extent(chart), hidden = group.hidden, tip = tooltip(holder);
    const far = beyond(chart, view);
    if (far) make("span", "count", holder.closest("figure").querySelector("figcaption"), ` ${far} beyond the axes.`);
    let u;
    const entries = first ? lineEntries(chart, palette) : [];
    for (const c of chart.clouds) {
      entries.push({ key: c.name, label: words(c.name), mark: "dot", paint: e => { e.style.background = theme.cloud; } });
      if (c.w.includes(0))
        entries.push({ key: c.name + "\u0000out", label: "outliers", mark: "ring", paint: e => { e.style.borderColor = theme.outlier; } });
    }
    const nearest = (left, top) => {
      let best = null, reach = 20 * 20;
      for (const c of chart.clouds) for (let i = 0; i < c.x.length; i++) {
        if (hidden.has(c.w[i] === 0 ? c.name + "\u0000out" : c.name)) continue;
        const dx = u.valToPos(c.x[i], "x") - left, dy = u.valToPos(c.y[i], "y") - top;
        if (dx * dx + dy * dy < reach) { reach = dx * dx + dy * dy; best = [c, i]; }
      }
      return best;
    };
    const hover = () => {
      const { left, top } = u.cursor;
      if (left == null || left < 0) return tip.hide();
      const xr = u.scales.x.max - u.scales.x.min, yr = u.scales.y.max - u.scales.y.min;
      const withUnit = (v, r, axis) => figure(v, r) + (axis.unit && axis.unit !== "°" ? " " : "") + axis.unit;
      const rows = [[chart.x.label, withUnit(u.posToVal(left, "x"), xr, chart.x)]];
      for (const l of chart.lines) {
        if (hidden.has(l.name)) continue;
        const x = u.posToVal(left, "x");
        const i = l.x.findIndex(v => v >= x);
        if (i < 1 || l.y[i] == null || l.y[i - 1] == null) continue;
        const t = (x - l.x[i - 1]) / (l.x[i] - l.x[i - 1] || 1);
        const at = a => a[i - 1] + t * (a[i] - a[i - 1]);
        rows.push([l.label, withUnit(at(l.y), yr, chart.y)]);
        if (l.lo.length && l.lo[i] != null && l.lo[i - 1] != null)
          rows.push(["  95 % band", `${figure(at(l.lo), yr)} to ${figure(at(l.hi), yr)}`]);
      }
      const found = nearest(left, top);
      if (found) {
        const [c, i] = found, s = kinds.get(c.m[i]);
        rows.push(["point", `${figure(c.x[i], xr)}, ${figure(c.y[i], yr)}`]);
        rows.push(["  weight", c.w[i] === 0 ? "0, outlier" : String(c.w[i])]);
        if (c.m[i] != null) rows.push(["  manoeuvre", `${c.m[i]}${s ? " " + words(s.kind) + (s.direction ? " " + s.direction : "") : ""}`]);
      }
      tip.show(u, left, rows);
    };
    const build = () => {
      if (u) u.destroy();
      const width = printing ? 330 : holder.clientWidth, c = columns(chart, hidden, palette());
      u = new uPlot({
        width, height: chart.height || Math.round(Math.max(230, Math.min(320, width * 0.62))),
        series: c.series, bands: c.bands,
        scales: { x: { time: false, auto: false, range: asked(view) }, y: { auto: false, range: view.y } },
        axes: axes(chart, false), legend: { show: false },
        cursor: {
          y: false, points: { show: false }, drag: chart.group ? { x: true, y: false } : { x: true, y: true, uni: 24 },
          ...(chart.group ? { sync: { key: chart.group, setSeries: false, scales: ["x", null], filters: { pub: type => type === "mousemove" || type === "mouseleave" } } } : {}),
          bind: { dblclick: () => () => { reset(u, view); return null; } },
        },
        hooks: {
          drawAxes: [v => { zeroLines(v); for (const c of chart.clouds) drawCloud(v, c, hidden); }],
          setCursor: [() => { if (u) hover(); }],
          setScale: [(v, key) => {
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
      reset(u, view);
    };
    build();
    group.now.push(() => u);
    group.builds.push(build);
    legend(holder, entries, hidden, () => group.builds.forEach(f => f()));
    holder.addEventListener("blur", tip.hide);
    keys(holder, () => u, () => reset(u, view));
    follow(holder, () => u);
    drawn.push(() => { build(); entries.forEach(e => e.repaint && e.repaint()); });
  };

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
      hatches.set(colour, ctx.createPattern(tile, "repeat"));
    }
    return hatches.get(colour);
  };
  const letter = s => s.kind !== "cornering" ? LETTERS[s.kind] || ""
    : s.direction === "left" ? "\u21b6" : s.direction === "right" ? "\u21b7" : "";
  const shade = (u, lane) => {
    const { ctx, bbox } = u, px = devicePixelRatio || 1;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const s of data.segments) {
      if (s.kind === "other" && !s.used) continue;
      const a = u.valToPos(s.start, "x", true), b = u.valToPos(s.end, "x", true);
      if (b < bbox.left || a > bbox.left + bbox.width) continue;
      const colour = theme.kind(s.kind), w = Math.max(b - a, px);
      ctx.fillStyle = s.used ? alpha(colour, 0.22) : hatch(colour);
      ctx.fillRect(a, bbox.top, w, bbox.height);
      if (!lane) continue;
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
      const s = data.segments.find(v => v.start <= t && t < v.end);
      if (s) {
        rows.push([`${words(s.kind)}${s.direction ? " " + s.direction : ""}`, `no. ${s.id}`]);
        if (s.quality != null) rows.push(["  quality", String(s.quality)]);
        rows.push([s.used ? "  used" : "  not used" + (s.reason ? ": " + s.reason : "")]);
      }
      tip.show(u, left, rows);
    };
    const home = () => reset(u, view);
    const build = () => {
      if (u) u.destroy();
      const width = printing ? 680 : holder.clientWidth, c = columns(chart, hidden, theme.traces);
      u = new uPlot({
        width, height: 92 + (index === 0 ? 26 : 0) + (last ? 42 : 0), series: c.series, bands: c.bands,
        scales: { x: { time: false, auto: false, range: asked(view) }, y: { auto: false, range: view.y } },
        axes: axes(chart, true, !last), legend: { show: false },
        cursor: {
          y: false, points: { show: false }, drag: { x: true, y: false },
          sync: { key: "time", setSeries: false, scales: ["x", null], filters: { pub: type => type === "mousemove" || type === "mouseleave" } },
          bind: { dblclick: () => () => { home(); return null; } },
        },
        hooks: {
          drawClear: [v => shade(v, index === 0)],
          drawAxes: [zeroLines],
          setCursor: [() => { if (u) hover(); }],
          setScale: [(v, key) => {
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
      home();
    };
    build();
    panels.push(() => u);
    const entries = lineEntries(chart, () => theme.traces);
    legend(holder, entries, hidden, build);
    keys(holder, () => { u.hovered = true; return u; }, home);
    holder.addEventListener("blur", () => { u.hovered = false; tip.hide(); });
    follow(holder, () => u);
    drawn.push(() => { build(); entries.forEach(e => e.repaint && e.repaint()); });
  };

  const swatches = () => {
    for (const e of document.querySelectorAll(".swatch")) {
      e.style.background = theme.kind(e.dataset.kind);
      if (e.closest(".kinds")) e.textContent = LETTERS[e.dataset.kind] || "";
    }
  };
  readTheme();
  swatches();
  for (const e of document.querySelectorAll("[data-chart]")) fit(e, data.charts[+e.dataset.chart]);
  document.querySelectorAll("[data-panel]").forEach((e, i) => panel(e, data.panels[+e.dataset.panel], i));

  const redraw = () => { readTheme(); hatches.clear(); swatches(); drawn.forEach(f => f()); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => { document.querySelectorAll("details.all").forEach(e => { e.open = true; }); printing = true; root.dataset.print = ""; redraw(); });
  addEventListener("afterprint", () => { printing = false; delete root.dataset.print; redraw(); });
})();
