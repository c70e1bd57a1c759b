// Data clouds: the points, their colours, and which manoeuvre is picked out on all charts.

// The picked manoeuvre: its points stay, the others step back; its segment is framed.
const segments = new Map(data.segments.map(s => [s.id, s]));
const picked = { id: null, redraws: [] };
const called = id => {
  const s = segments.get(id);
  return `${id}${s ? " " + words(s.kind) + (s.direction ? " " + s.direction : "") : ""}`;
};
const note = document.getElementById("picked");
const pick = id => {
  picked.id = id == null || picked.id === id ? null : id;
  address.put("manoeuvre", picked.id == null ? null : String(picked.id));
  picked.redraws.forEach(f => f());
  for (const b of document.querySelectorAll("button[data-manoeuvre]"))
    b.setAttribute("aria-pressed", String(+b.dataset.manoeuvre === picked.id));
  if (!note) return;
  note.hidden = picked.id == null;
  note.firstElementChild.textContent = picked.id == null ? "" : `Manoeuvre ${called(picked.id)} is highlighted on every chart.`;
};

// Least and largest shade, but for the outermost twentieth: one odd load must not take the ramp.
const shades = chart => {
  const all = chart.clouds.flatMap(c => c.s || []).filter(v => v != null).sort((a, b) => a - b);
  if (!all.length) return null;
  const skip = Math.floor(all.length / 20);
  return [all[skip], all[all.length - 1 - skip]];
};
const share = (value, range) => range[1] > range[0] ? (value - range[0]) / (range[1] - range[0]) : 0.5;

const isHidden = (cloud, i, hidden) => hidden.has(cloud.w[i] === 0 ? cloud.name + "\u0000out" : cloud.name);

const drawCloud = (u, cloud, hidden, range) => {
  const { ctx, bbox } = u, px = devicePixelRatio || 1;
  const r = (cloud.r || 2) * px, dense = cloud.r ? 1 : Math.min(1, Math.max(0.45, 500 / cloud.x.length));
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (let i = 0; i < cloud.x.length; i++) {
    if (isHidden(cloud, i, hidden)) continue;
    const x = u.valToPos(cloud.x[i], "x", true), y = u.valToPos(cloud.y[i], "y", true);
    const own = picked.id != null && cloud.m[i] === picked.id;
    const back = picked.id != null && !own ? 0.15 : 1;
    const colour = range && cloud.s && cloud.s[i] != null ? ramp(share(cloud.s[i], range)) : theme.cloud;
    if (cloud.lo && cloud.lo[i] != null) {
      ctx.strokeStyle = alpha(colour, 0.35 * back);
      ctx.lineWidth = px;
      ctx.beginPath();
      ctx.moveTo(x, u.valToPos(cloud.lo[i], "y", true));
      ctx.lineTo(x, u.valToPos(cloud.hi[i], "y", true));
      ctx.stroke();
    }
    ctx.beginPath();
    ctx.arc(x, y, own ? r * 1.5 : r, 0, 2 * Math.PI);
    if (cloud.w[i] === 0) {
      ctx.strokeStyle = alpha(theme.outlier, 0.6 * back);
      ctx.lineWidth = px;
      ctx.stroke();
    } else {
      ctx.fillStyle = alpha(colour, (0.25 + 0.7 * cloud.w[i]) * (own ? 1 : dense * back));
      ctx.fill();
    }
  }
  ctx.restore();
};

// Lines that turn back, from point to point, each with its bands.
const drawPaths = (u, chart, hidden, palette) => {
  const { ctx, bbox } = u, px = devicePixelRatio || 1;
  chart.lines.forEach((line, k) => {
    if (!line.path || hidden.has(line.name)) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const colour = palette[(line.colour ?? k) % palette.length];
    const at = (i, y) => [u.valToPos(line.x[i], "x", true), u.valToPos(y[i], "y", true)];
    for (const [low, high, key, share] of bandsOf(line)) {
      if (hidden.has(key)) continue;
      const known = line.x.map((_, i) => i).filter(i => low[i] != null && high[i] != null);
      ctx.fillStyle = alpha(colour, share);
      ctx.beginPath();
      known.forEach((i, n) => ctx[n ? "lineTo" : "moveTo"](...at(i, low)));
      known.reverse().forEach(i => ctx.lineTo(...at(i, high)));
      ctx.closePath();
      ctx.fill();
    }
    ctx.strokeStyle = colour;
    ctx.lineWidth = 2 * px;
    ctx.beginPath();
    line.x.forEach((x, i) => ctx[i ? "lineTo" : "moveTo"](u.valToPos(x, "x", true), u.valToPos(line.y[i], "y", true)));
    ctx.stroke();
    ctx.restore();
  });
};

// The point nearest to the cursor: by keys the nearest abscissa counts, whatever its height.
const nearest = (u, chart, hidden) => {
  const { left, top } = u.cursor;
  let best = null, reach = 20 * 20;
  for (const c of chart.clouds) for (let i = 0; i < c.x.length; i++) {
    if (isHidden(c, i, hidden)) continue;
    const dx = u.valToPos(c.x[i], "x") - left, dy = u.byKeys ? 0 : u.valToPos(c.y[i], "y") - top;
    if (dx * dx + dy * dy < reach) { reach = dx * dx + dy * dy; best = [c, i]; }
  }
  return best;
};

// What a point says of itself.
const told = (chart, [c, i], xr, yr) => {
  const rows = [];
  if (c.t) rows.push([c.t[i]]);
  rows.push([c.t ? "value" : "point", c.t ? withUnit(c.y[i], yr, chart.y) : `${withUnit(c.x[i], xr, chart.x)}, ${withUnit(c.y[i], yr, chart.y)}`]);
  if (c.lo && c.lo[i] != null) rows.push(["  95 % interval", `${figure(c.lo[i], yr)} to ${withUnit(c.hi[i], yr, chart.y)}`]);
  if (chart.shade && c.s && c.s[i] != null) rows.push([`  ${chart.shade.label}`, withUnit(c.s[i], 400, chart.shade)]);
  if (c.fitted) rows.push(["  weight", c.w[i] === 0 ? "0, outlier" : String(c.w[i])]);
  if (c.n && c.n[i] > 1) rows.push(["  stands for", `${c.n[i]} samples`]);
  if (c.m[i] != null) rows.push(["  manoeuvre", called(c.m[i])]);
  return rows;
};
