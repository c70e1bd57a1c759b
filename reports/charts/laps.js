// Laps: map, g-g diagram, time behind the best lap. Drawn as SVG; the picked lap is in all of them.
const track = data.laps;
const lapCharts = () => {
  const at = name => document.querySelector(`[data-lap-chart="${name}"]`);
  const svg = element;
  const best = track.laps.find(l => l.best) || track.laps[0];
  let now = best, cursor = null;
  const n = track.s.length, end = track.s[n - 1];
  const known = list => list.filter(v => v != null);
  const largest = Math.max(...track.laps.flatMap(l => known(l.used)), 0.1);
  const full = track.available || largest;
  const canvas = (holder, height) => {
    const width = Math.max(holder.clientWidth, 200);
    holder.replaceChildren();
    return [svg("svg", holder, { width, height, class: "laps-svg" }), width];
  };
  const nearest = s => { let k = 0; while (k + 1 < n && track.s[k + 1] <= s) k++; return k; };
  const path = points => points.map((p, i) => `${i ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join("");
  // a scale of the ramp with its two ends in words
  const scale = (parent, x, y, width, low, high) => {
    for (let i = 0; i < 24; i++)
      svg("rect", parent, { x: x + width * i / 24, y, width: width / 24 + 0.5, height: 8, fill: ramp((i + 0.5) / 24) });
    svg("text", parent, { x, y: y + 21 }, low);
    svg("text", parent, { x: x + width, y: y + 21, "text-anchor": "end" }, high);
  };

  const map = holder => {
    const low = a => Math.min(...a), high = a => Math.max(...a);
    const size = [high(track.x) - low(track.x), high(track.y) - low(track.y)];
    const wide = Math.max(holder.clientWidth, 200), margin = 22;
    const height = Math.max(180, Math.min(430, (wide - 2 * margin) * size[1] / Math.max(size[0], 1) + 2 * margin)) + 34;
    const [s, width] = canvas(holder, height);
    const per = Math.min((width - 2 * margin) / Math.max(size[0], 1), (height - 34 - 2 * margin) / Math.max(size[1], 1));
    const off = [(width - per * size[0]) / 2, (height - 34 - per * size[1]) / 2];
    const place = k => [off[0] + per * (track.x[k] - low(track.x)), height - 34 - off[1] - per * (track.y[k] - low(track.y))];
    const all = track.s.map((_, k) => place(k));
    svg("path", s, { d: path(all) + "Z", fill: "none", stroke: theme.grid, "stroke-width": 11, "stroke-linejoin": "round" });
    const STEPS = 20, step = k => now.used[k] == null ? null : Math.min(STEPS, Math.round(STEPS * now.used[k] / full));
    for (let k = 0; k + 1 < n;) {
      let to = k + 1;
      while (to + 1 < n && step(to) === step(k)) to++;
      const colour = step(k) == null ? theme.zero : ramp(step(k) / STEPS);
      svg("path", s, { d: path(all.slice(k, to + 1)), fill: "none", stroke: colour, "stroke-width": 5.5, "stroke-linejoin": "round", "stroke-linecap": "round" });
      k = to;
    }
    const across = (k, length) => {
      const a = all[Math.max(0, k - 1)], b = all[Math.min(n - 1, k + 1)], d = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      return [-(b[1] - a[1]) / d * length, (b[0] - a[0]) / d * length];
    };
    const w = across(0, 9);
    svg("path", s, { d: path([[all[0][0] - w[0], all[0][1] - w[1]], [all[0][0] + w[0], all[0][1] + w[1]]]), stroke: theme.ink, "stroke-width": 2.5 });
    for (const c of track.corners) {
      const k = nearest(c.s), side = across(k, 15);
      // to the outside: away from where the track bends to
      const [a, b] = [all[Math.max(0, k - 6)], all[Math.min(n - 1, k + 6)]];
      const inward = [(a[0] + b[0]) / 2 - all[k][0], (a[1] + b[1]) / 2 - all[k][1]];
      const sign = inward[0] * side[0] + inward[1] * side[1] > 0 ? -1 : 1;
      svg("text", s, { x: all[k][0] + sign * side[0], y: all[k][1] + sign * side[1] + 4, "text-anchor": "middle", class: "turn" }, c.n);
    }
    scale(s, 2, height - 26, Math.min(220, width - 20), "0", `100 % (${full.toFixed(2)} g)`);
    if (cursor != null) svg("circle", s, { cx: all[cursor][0], cy: all[cursor][1], r: 6, fill: "none", stroke: theme.ink, "stroke-width": 2.5 });
  };

  const gg = holder => {
    const wide = Math.max(holder.clientWidth, 200), side = Math.min(wide, 430);
    const [s, width] = canvas(holder, side + 30);
    const reach = 1.08 * Math.max(full, ...known(now.ax).map(Math.abs), ...known(now.ay).map(Math.abs));
    const mid = [width / 2, side / 2], per = (side / 2 - 16) / reach;
    for (let g = 0.5; g <= reach; g += 0.5) {
      svg("circle", s, { cx: mid[0], cy: mid[1], r: g * per, fill: "none", stroke: theme.grid });
      svg("text", s, { x: mid[0] + 3, y: mid[1] - g * per - 3 }, `${g.toFixed(1)} g`);
    }
    svg("path", s, { d: `M${mid[0] - reach * per} ${mid[1]}H${mid[0] + reach * per}M${mid[0]} ${mid[1] - reach * per}V${mid[1] + reach * per}`, stroke: theme.zero, fill: "none" });
    if (track.available) svg("circle", s, { cx: mid[0], cy: mid[1], r: full * per, fill: "none", stroke: theme.outlier, "stroke-dasharray": "4 3" });
    const lean = Math.max(10, ...known(now.roll).map(Math.abs));
    for (let k = 0; k < n; k++) {
      if (now.ax[k] == null || now.ay[k] == null) continue;
      const colour = now.roll[k] == null ? theme.cloud : ramp(Math.abs(now.roll[k]) / lean);
      svg("circle", s, { cx: (mid[0] + per * now.ay[k]).toFixed(1), cy: (mid[1] - per * now.ax[k]).toFixed(1), r: k === cursor ? 6 : 2.4, fill: colour, "fill-opacity": 0.85 });
    }
    if (known(now.roll).length) scale(s, 2, side + 2, Math.min(180, width - 20), "0\u00b0", `lean ${Math.round(lean)}\u00b0`);
  };

  const left = 46, right = 8; // beside the axes
  // lines over the distance; `values` of a lap, null for a gap
  const over = (holder, height, label, values, digits, foot) => {
    const [s, width] = canvas(holder, height);
    const top = 34, bottom = foot ? 34 : 8;
    const everything = track.laps.flatMap(l => known(values(l)));
    let [low, high] = [Math.min(...everything), Math.max(...everything)];
    const pad = 0.05 * (high - low) || 1;
    low -= pad; high += pad;
    const x = v => left + v / end * (width - left - right), y = v => top + (high - v) / (high - low) * (height - top - bottom);
    const raw = (high - low) / Math.max(2, (height - top - bottom) / 38), power = 10 ** Math.floor(Math.log10(raw));
    const unit = [1, 2, 5, 10].map(m => m * power).find(m => m >= raw);
    for (let v = Math.ceil(low / unit) * unit; v <= high; v += unit) {
      svg("path", s, { d: `M${left} ${y(v)}H${width - right}`, stroke: Math.abs(v) < unit / 1e6 ? theme.zero : theme.grid });
      svg("text", s, { x: left - 5, y: y(v) + 4, "text-anchor": "end" }, minus((Math.abs(v) < unit / 1e6 ? 0 : v).toFixed(Math.max(0, -Math.floor(Math.log10(unit) + 1e-9)))));
    }
    for (const c of track.corners) {
      svg("path", s, { d: `M${x(c.s)} ${top}V${height - bottom}`, stroke: theme.grid, "stroke-dasharray": "2 3" });
      svg("text", s, { x: x(c.s), y: top - 5, "text-anchor": "middle", class: "turn" }, c.n);
    }
    if (foot) {
      const raw = end / Math.max(2, (width - left - right) / 80), power = 10 ** Math.floor(Math.log10(raw));
      const unit = [1, 2, 5, 10].map(m => m * power).find(m => m >= raw);
      for (let v = 0; v <= end; v += unit) svg("text", s, { x: x(v), y: height - bottom + 15, "text-anchor": "middle" }, v);
      svg("text", s, { x: width - right, y: height - 3, "text-anchor": "end" }, "distance, m");
    }
    svg("text", s, { x: 0, y: 11 }, label);
    const line = (l, colour, wide) => {
      let d = "", pen = false;
      values(l).forEach((v, k) => {
        if (v != null) d += `${pen ? "L" : "M"}${x(track.s[k]).toFixed(1)} ${y(v).toFixed(1)}`;
        pen = v != null;
      });
      svg("path", s, { d, fill: "none", stroke: colour, "stroke-width": wide, "stroke-linejoin": "round" });
    };
    for (const l of track.laps) if (l !== now && l !== best) line(l, alpha(theme.soft, 0.6), 1.2);
    if (now !== best) line(best, theme.lines[1], 1.5);
    line(now, theme.lines[0], 2.5);
    const mark = k => {
      if (k == null) return;
      svg("path", s, { d: `M${x(track.s[k])} ${top}V${height - bottom}`, stroke: theme.soft });
      const v = values(now)[k];
      const text = v == null ? "" : `${Math.round(track.s[k])} m: ${minus(v.toFixed(digits))}`;
      svg("text", s, { x: width - right, y: 11, "text-anchor": "end" }, text);
    };
    mark(cursor);
  };

  const draw = () => {
    map(at("map"));
    gg(at("gg"));
    over(at("behind"), 205, "behind, s", l => l.d, 2, false);
    over(at("speed"), 205, "speed, km/h", l => l.v, 0, true);
  };
  const choose = lap => {
    now = lap;
    for (const e of document.querySelectorAll("[data-lap-name]")) e.textContent = `${lap.lap} (${lap.time})`;
    for (const b of document.querySelectorAll("button[data-lap]")) b.setAttribute("aria-pressed", String(+b.dataset.lap === lap.lap));
    address.put("lap", lap === best ? null : String(lap.lap));
    draw();
  };
  const asked = track.laps.find(l => String(l.lap) === address.get("lap"));
  for (const b of document.querySelectorAll("button[data-lap]"))
    b.addEventListener("click", () => { const l = track.laps.find(l => l.lap === +b.dataset.lap); if (l) choose(l); });
  // on the holder: the drawing in it is replaced while the pointer moves
  const point = k => { if (k !== cursor) { cursor = k; draw(); } };
  for (const name of ["behind", "speed"]) {
    const holder = at(name);
    holder.addEventListener("pointermove", event => {
      const box = holder.getBoundingClientRect();
      const s = (event.clientX - box.left - left) / (box.width - left - right) * end;
      point(s < 0 || s > end ? null : nearest(s));
    });
    holder.addEventListener("pointerleave", () => point(null));
  }
  choose(asked || best);
  const csv = () => rowsOf([
    ["lap", "lap time", "distance (m)", "x (m)", "y (m)", "behind (s)", "speed (km/h)", "roll (deg)", "ax (g)", "ay (g)", "friction used (g)"],
    ...track.laps.flatMap(l => track.s.map((s, k) => [l.lap, l.time, s, track.x[k], track.y[k], l.d[k], l.v[k], l.roll[k], l.ax[k], l.ay[k], l.used[k]])),
  ]);
  // drawings one below the other, each text with the style that the page gives it
  const drawing = names => () => {
    try {
      return onPaper(() => {
        draw();
        let height = 0, width = 0;
        const parts = names.map(name => {
          const from = at(name).firstChild, copy = from.cloneNode(true), texts = from.querySelectorAll("text");
          copy.querySelectorAll("text").forEach((e, i) => {
            const style = getComputedStyle(texts[i]);
            for (const [k, v] of [["fill", style.fill], ["font-size", "12"], ["font-weight", style.fontWeight]]) e.setAttribute(k, v);
            e.removeAttribute("class");
          });
          copy.removeAttribute("class");
          copy.setAttribute("y", height);
          height += +copy.getAttribute("height");
          width = Math.max(width, +copy.getAttribute("width"));
          return copy;
        });
        const title = at(names[0]).closest("figure").querySelector("figcaption strong").textContent;
        const key = [[`lap ${now.lap}`, theme.lines[0]], ...(now === best ? [] : [[`best lap ${best.lap}`, theme.lines[1]]])];
        return sheetOf(title, width, height, 1, { title, key: names.includes("speed") ? key : null }, parts);
      });
    } finally { draw(); }
  };
  for (const [name, title, names, data] of [["laps", "all laps", ["behind", "speed"], csv], ["lap_map", "map", ["map"]], ["gg", "g-g diagram", ["gg"]]])
    saves(at(names[0]).closest("figure"), name, title, { csv: data, drawing: drawing(names) });
  let width = at("map").clientWidth;
  new ResizeObserver(() => {
    if (!printing && at("map").clientWidth !== width) { width = at("map").clientWidth; draw(); }
  }).observe(at("map"));
  drawn.push(draw);
};
