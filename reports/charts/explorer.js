// The tyre explorer: one or two fitted tyres at a load, camber and road of the reader's choice.

const DEGREES = 180 / Math.PI;
const between = (xs, ys, x) => {
  if (!xs.length || x < xs[0] || x > xs[xs.length - 1]) return null;
  const i = Math.max(1, xs.findIndex(v => v >= x));
  if (xs.length < 2 || ys[i] == null || ys[i - 1] == null) return null;
  const t = (x - xs[i - 1]) / (xs[i] - xs[i - 1] || 1);
  return ys[i - 1] + t * (ys[i] - ys[i - 1]);
};
for (const t of data.tyres) {
  if (data.tyres.some(o => o !== t && o.name.replace(/^.*: /, "") === t.name)) t.name = `${t.bike}: ${t.name}`;
  for (const b of Object.values(t.bands)) for (const name of Object.keys(b)) b[name] = unstep(b[name]);
  Object.assign(t, tyreModel(t.parameters));
  // the band below and above a curve of the report, at one abscissa; null beyond what was ridden
  t.off = (band, x) => {
    const b = t.bands[band], [low, y, high] = ["low", "y", "high"].map(n => between(b.x, b[n], x));
    return low == null || y == null || high == null ? null : { y, low: y - low, high: high - y };
  };
}
const wrong = data.tyres.some(t => (t.check || []).some(([input, output]) =>
  t.forces(...input).some((f, i) => !(Math.abs(f - output[i]) <= 1e-6 * (Math.abs(output[i]) + input[3] * 1e-3)))));

const at = id => document.getElementById(id);
const controls = { a: at("tyre-a"), b: at("tyre-b"), show: at("show"), load: at("load"), camber: at("camber"), mu: at("mu"), angle: at("angle"), slip: at("slip") };
const number = name => Number(controls[name].value);
const setting = () => ({ load: number("load"), gamma: number("camber") / DEGREES, mu: number("mu"), angle: number("angle") / DEGREES, slip: number("slip") / 100 });

// Each view: axes, abscissae, value with what is below and above it, whether a place was ridden, what it needs.
// A side force is -(k_alpha angle + k_gamma camber): both stiffnesses have the error of one fit, and where they pull
// against each other it does not cancel, as their ratio is assumed.
const sideBand = (t, angle, gamma, load, mu) => {
  const alphas = t.off("stiffness", Math.abs(gamma)), gammas = t.off("camber", Math.abs(gamma)), most = t.circle(mu) * load;
  const force = t.forces(0, angle, gamma, load, mu)[1];
  if (!alphas || !gammas || Math.abs(force) >= 0.999 * most) return null;
  // a larger stiffness makes a negative force of a positive angle larger
  const of = (x, b) => x > 0 ? [x * b.high, x * b.low] : [-x * b.low, -x * b.high];
  const [a, g] = [of(angle, alphas), of(gamma, gammas)], apart = angle * gamma < 0;
  const [low, high] = [0, 1].map(i => (apart ? Math.hypot(a[i], g[i]) : a[i] + g[i]) * load);
  return [Math.min(low, force + most), Math.min(high, most - force)]; // no more than the road holds
};
// friction is fitted to straight-line braking
const upright = s => Math.abs(s.gamma) < 0.09;
// how friction changes with load is assumed: far from the loads of braking nothing bounds it
const bounded = (t, s) => within(s.load, t.ridden.bounded);
const FAR = "far from the loads under which the wheel was braked";
const slipBand = (t, slip, s) => {
  const b = !upright(s) || !bounded(t, s) ? null : t.off("friction", slip * t.stiffer(s.load) / s.mu);
  return b && [b.low, b.high].map(size => size * s.load * s.mu);
};
const within = (value, ends) => ends != null && value >= ends[0] - 1e-9 && value <= ends[1] + 1e-9;
const either = size => size == null ? null : [-size, size];
// of a slip all down to none; loads and road as they were
const asRidden = (t, s) => within(s.load, t.ridden.load) && s.mu === 1;
const slipRidden = (t, slip) => t.ridden.slip != null && within(slip, [Math.min(0, t.ridden.slip[0]), Math.max(0, t.ridden.slip[1])]);
const angleRidden = (t, angle) => within(angle, either(t.ridden.angle));
const camberRidden = (t, gamma) => within(gamma, either(t.ridden.camber));
const VIEWS = {
  longitudinal: {
    x: { label: "slip ratio", unit: "%" }, y: { label: "longitudinal force Fx", unit: "N" }, range: [-40, 20], needs: "longitudinal",
    value: (t, x, s) => t.forces(x / 100, 0, s.gamma, s.load, s.mu)[0], band: (t, x, s) => slipBand(t, x / 100, s),
    why: (t, s) => bounded(t, s) ? "" : FAR,
    ridden: (t, x, s) => asRidden(t, s) && upright(s) && slipRidden(t, x / 100), uses: ["load", "camber", "mu"],
  },
  lateral: {
    x: { label: "slip angle", unit: "\u00b0" }, y: { label: "side force Fy", unit: "N" }, range: [-10, 10], needs: "lateral",
    value: (t, x, s) => t.forces(s.slip, x / DEGREES, s.gamma, s.load, s.mu)[1],
    band: (t, x, s) => s.slip === 0 ? sideBand(t, x / DEGREES, s.gamma, s.load, s.mu) : null,
    ridden: (t, x, s) => asRidden(t, s) && s.slip === 0 && angleRidden(t, x / DEGREES) && camberRidden(t, s.gamma), uses: ["load", "camber", "mu", "slip"],
  },
  leaning: {
    x: { label: "camber", unit: "\u00b0" }, y: { label: "side force Fy", unit: "N" }, range: [-55, 55], needs: "lateral",
    value: (t, x, s) => t.forces(0, s.angle, x / DEGREES, s.load, s.mu)[1], band: (t, x, s) => sideBand(t, s.angle, x / DEGREES, s.load, s.mu),
    ridden: (t, x, s) => asRidden(t, s) && camberRidden(t, x / DEGREES) && angleRidden(t, s.angle), uses: ["load", "camber", "mu", "angle"],
  },
  combined: {
    x: { label: "longitudinal force Fx", unit: "N" }, y: { label: "side force Fy", unit: "N" }, equal: true, needs: "both", uses: ["load", "camber", "mu"],
  },
  yaw: {
    x: { label: "slip angle", unit: "\u00b0" }, y: { label: "yaw moment Mz", unit: "N m" }, range: [-10, 10], needs: "lateral",
    value: (t, x, s) => t.forces(s.slip, x / DEGREES, s.gamma, s.load, s.mu)[3], band: () => null,
    ridden: (t, x, s) => asRidden(t, s) && s.slip === 0 && angleRidden(t, x / DEGREES) && camberRidden(t, s.gamma), uses: ["load", "camber", "mu", "slip"],
  },
  overturning: {
    x: { label: "camber", unit: "\u00b0" }, y: { label: "overturning moment Mx", unit: "N m" }, range: [-55, 55], needs: "lateral",
    value: (t, x, s) => t.forces(0, 0, x / DEGREES, s.load, s.mu)[2],
    band: (t, x, s) => t.crown && (x > 0 ? [t.crown[1], t.crown[0]] : t.crown).map(size => Math.abs(size * s.load * Math.tan(x / DEGREES))),
    ridden: (t, x, s) => within(s.load, t.ridden.load) && camberRidden(t, x / DEGREES), uses: ["load", "camber", "mu"],
  },
};
const ANGLES = [0, 1, 2, 4, 8];
const STEPS = 240;

// What is drawn of one tyre: runs of points, each ridden or not, with the ends of its band.
const curveOf = (t, view, s) => {
  const [from, to] = view.range, out = [];
  for (let i = 0; i <= STEPS; i++) {
    const x = from + (to - from) * i / STEPS, y = view.value(t, x, s), b = view.band(t, x, s);
    out.push({ x, y, low: b && y - b[0], high: b && y + b[1], ridden: view.ridden(t, x, s) });
  }
  return [{ name: t.name, points: out }];
};
// whether the radius of the friction circle is the peak friction, and has its interval
const radiusKnown = t => t.peak != null && Math.abs(t.parameters.mf_d) >= t.parameters.lateral_peak;
const ellipseOf = (t, s) => {
  const most = t.circle(s.mu) * s.load, rim = [];
  // both forces at once were not ridden: the combined slip is the model's rule
  const single = (x, y) => Math.min(Math.abs(x), Math.abs(y)) <= most / 20;
  const curves = ANGLES.map(angle => ({ name: `slip angle ${angle}\u00b0`, points: [] }));
  ANGLES.forEach((angle, n) => {
    for (let i = 0; i <= STEPS; i++) {
      const u = -1 + 2 * i / STEPS, slip = Math.sign(u) * (u < 0 ? 0.95 : 0.6) * Math.abs(u) ** 2.5;
      const [x, y] = t.forces(slip, -angle / DEGREES, s.gamma, s.load, s.mu);
      curves[n].points.push({ x, y, slip, low: null, high: null, ridden: asRidden(t, s) && single(x, y) && slipRidden(t, slip) && angleRidden(t, angle / DEGREES) });
    }
  });
  for (let i = 0; i <= 120; i++) rim.push({ x: most * Math.cos(i * Math.PI / 60), y: most * Math.sin(i * Math.PI / 60), low: null, high: null, ridden: false });
  const known = radiusKnown(t) && bounded(t, s) && most > 0;
  return [...curves, { name: "friction circle", points: rim, rim: true, ring: known ? [most - t.peak[0] * s.mu * s.load, most + t.peak[1] * s.mu * s.load].map(r => r / most) : null }];
};

let shown = [], u = null, home = null, unknown = "";
const lacks = (t, view) => {
  const missing = ["longitudinal", "lateral"].filter(half => (view.needs === half || view.needs === "both") && !t[half]);
  return missing.length ? `${t.name}: this ride did not give the ${missing.join(" and ")} half of the tyre.` : null;
};
const chosen = () => [controls.a, controls.b].map(c => c.value === "" ? null : data.tyres[+c.value]);

const path = (points, draw) => {
  const { ctx } = u;
  ctx.beginPath();
  points.forEach((p, i) => {
    const x = u.valToPos(p.x, "x", true), y = u.valToPos(p.y, "y", true);
    if (i) ctx.lineTo(x, y); else ctx.moveTo(x, y);
  });
  draw(ctx);
};
const paint = () => {
  const { ctx, bbox } = u, px = devicePixelRatio || 1;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  zeroLines(u);
  for (const { curves, colour } of shown) for (const c of curves) {
    const banded = c.points.filter(p => p.low != null);
    if (banded.length > 1) {
      const edge = [...banded.map(p => ({ x: p.x, y: p.high })), ...banded.reverse().map(p => ({ x: p.x, y: p.low }))];
      path(edge, k => { k.fillStyle = alpha(colour(), 0.2); k.fill(); });
    }
    if (c.ring) {
      const [inner, outer] = c.ring.map(size => c.points.map(p => ({ x: size * p.x, y: size * p.y })));
      path([...outer, ...inner.reverse()], k => { k.fillStyle = alpha(colour(), 0.2); k.fill(); });
    }
    // runs of the same kind: solid where it was ridden
    for (let i = 0; i < c.points.length - 1;) {
      let j = i + 1;
      while (j < c.points.length - 1 && c.points[j].ridden === c.points[i].ridden) j++;
      path(c.points.slice(i, j + 1), k => {
        k.strokeStyle = c.rim ? alpha(colour(), 0.7) : colour();
        k.lineWidth = (c.rim ? 1 : 2) * px;
        k.setLineDash(c.points[i].ridden ? [] : c.rim ? [2 * px, 4 * px] : [6 * px, 4 * px]);
        k.stroke();
      });
      i = j;
    }
  }
  if (controls.show.value === "combined" && shown.length) {
    ctx.font = `${11 * px}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    for (const c of shown[0].curves.filter(c => !c.rim)) {
      const p = c.points[STEPS / 2];
      ctx.fillStyle = shown[0].colour();
      ctx.fillText(c.name.replace("slip angle ", ""), u.valToPos(p.x, "x", true), u.valToPos(p.y, "y", true) - 4 * px);
    }
  }
  if (controls.show.value !== "combined") for (const p of bench()) {
    ctx.setLineDash([]);
    ctx.fillStyle = theme.ink;
    ctx.beginPath();
    ctx.arc(u.valToPos(p.x, "x", true), u.valToPos(p.y, "y", true), 3 * px, 0, 2 * Math.PI);
    ctx.fill();
  }
  ctx.restore();
};
// Points of a tyre bench near the chosen load and camber, of the tyres that are shown.
const bench = () => {
  const s = setting(), view = controls.show.value, wheels = new Set(chosen().filter(Boolean).map(t => t.tyre));
  return data.bench.filter(p => wheels.has(p.tyre) && Math.abs(p.load / s.load - 1) < 0.15 && s.mu === 1).flatMap(p => {
    const leans = Math.abs(p.camber - s.gamma) < 0.035, still = Math.abs(p.slip) < 0.005;
    if (view === "longitudinal" && leans && Math.abs(p.angle) < 0.0045 && p.fx != null) return [{ x: 100 * p.slip, y: p.fx }];
    if (view === "lateral" && leans && still && s.slip === 0 && p.fy != null) return [{ x: DEGREES * p.angle, y: p.fy }];
    if (view === "leaning" && still && Math.abs(p.angle - s.angle) < 0.0045 && p.fy != null) return [{ x: DEGREES * p.camber, y: p.fy }];
    return [];
  });
};

const holder = at("explorer"), tip = tooltip(holder);
const extentOf = () => {
  const all = shown.flatMap(o => o.curves.flatMap(c => c.points));
  const range = (pick, share) => {
    const values = all.flatMap(pick).filter(v => v != null);
    const low = Math.min(...values), high = Math.max(...values), pad = share * (high - low || 1);
    return [low - pad, high + pad];
  };
  if (!all.length) return { x: [-1, 1], y: [-1, 1] };
  return { x: range(p => [p.x], controls.show.value === "combined" ? 0.05 : 0), y: range(p => [p.y, p.low, p.high], 0.05) };
};
const hover = () => {
  const view = VIEWS[controls.show.value], { left, top } = u.cursor;
  if (left == null || left < 0) return tip.hide();
  const xr = u.scales.x.max - u.scales.x.min, yr = u.scales.y.max - u.scales.y.min, rows = [];
  if (view.value) {
    const x = u.posToVal(left, "x"), s = setting();
    rows.push([view.x.label, withUnit(x, xr, view.x)]);
    for (const { tyre } of shown) {
      const y = view.value(tyre, x, s), b = view.band(tyre, x, s);
      rows.push([tyre.name, withUnit(y, yr, view.y)]);
      rows.push(b ? ["  95 % interval", `${figure(y - b[0], yr)} to ${withUnit(y + b[1], yr, view.y)}`] : ["  no interval here", (view.why && view.why(tyre, s)) || (view.ridden(tyre, x, s) ? "" : "not ridden")]);
    }
  } else {
    const x = u.posToVal(left, "x"), y = u.posToVal(top, "y");
    let best = null;
    for (const o of shown) for (const c of o.curves) for (const p of c.points) {
      const d = Math.hypot((p.x - x) / xr, (p.y - y) / yr);
      if (!best || d < best.d) best = { d, p, c, o };
    }
    if (!best || best.d > 0.1) return tip.hide();
    rows.push([best.o.tyre.name, best.c.name], ["Fx", withUnit(best.p.x, xr, view.x)], ["Fy", withUnit(best.p.y, yr, view.y)]);
    if (best.p.slip != null) rows.push(["slip ratio", `${figure(100 * best.p.slip, 10)} %`]);
  }
  tip.show(u, left, rows);
};
const build = () => {
  if (u) u.destroy();
  const view = VIEWS[controls.show.value], width = printing ? Math.min(640, holder.clientWidth) : holder.clientWidth, height = Math.round(Math.max(260, Math.min(460, width * 0.55)));
  const extent = extentOf();
  home = view.equal ? levelled(extent, width, height) : extent;
  u = new uPlot({
    width, height, series: [{}, { show: false }],
    scales: { x: { time: false, auto: false, range: (v, min, max) => min == null ? home.x : [min, max] }, y: { auto: false, range: (v, min, max) => min == null ? home.y : [min, max] } },
    axes: axes(view, false), legend: { show: false },
    cursor: { y: false, points: { show: false }, drag: { x: true, y: true, uni: 24 }, bind: { dblclick: () => () => { reset(u, home); return null; } } },
    hooks: { draw: [paint], setCursor: [() => { if (u) hover(); }] },
  }, [[0, 1], [null, null]], holder);
  u.over.addEventListener("mouseleave", () => tip.hide());
  reset(u, home);
  holder.uplot = u; // for tests and for the curious
};

// The chosen tyres' numbers at the chosen load, camber and road.
const span = (y, b, digits) => b ? `${minus((y - b[0]).toFixed(digits))} to ${minus((y + b[1]).toFixed(digits))}` : "\u2013";
// The slip of the largest braking force.
const peakOf = (t, s) => {
  let slip = 0, least = 0;
  for (let i = 1; i <= 400; i++) {
    const force = t.forces(-i / 400, 0, s.gamma, s.load, s.mu)[0];
    if (force < least) [slip, least] = [-i / 400, force];
  }
  // between the neighbours of the best of these
  for (let i = -50, middle = slip; i <= 50; i++) {
    const at = Math.max(-1, Math.min(0, middle + i / 20000)), force = t.forces(at, 0, s.gamma, s.load, s.mu)[0];
    if (force < least) [slip, least] = [at, force];
  }
  return [slip, -least];
};
// why a longitudinal force has no interval at a slip
const unbounded = (t, slip, s) => !upright(s) ? "braking while leant was not ridden" : !bounded(t, s) ? FAR : slipRidden(t, slip) ? "" : "beyond the slips that were braked";
const NUMBERS = [
  ["Largest braking force, N", "longitudinal", (t, s) => {
    const [slip, force] = peakOf(t, s), b = slipBand(t, slip, s);
    return [force, b && [b[1], b[0]], 0, unbounded(t, slip, s)];
  }],
  ["That force over the load", "longitudinal", (t, s) => {
    const [slip, force] = peakOf(t, s), b = slipBand(t, slip, s);
    return [force / s.load, b && [b[1] / s.load, b[0] / s.load], 3, unbounded(t, slip, s)];
  }],
  ["Slip there, %", "longitudinal", (t, s) => {
    if (t.peak_slip == null) return [null, null, 1, "the peak was not reached"];
    // a slip counts as more under more load, and as less on a road of more friction
    const per = 100 * s.mu / t.stiffer(s.load), ends = upright(s) && bounded(t, s) ? t.peak_slip_ends : null;
    const why = !t.peak_slip ? "poorly determined" : upright(s) ? FAR : "braking while leant was not ridden";
    return [-100 * peakOf(t, s)[0], ends && ends.map(size => size * per), 1, why, ends && !t.peak_slip ? why : ""];
  }],
  ["Cornering stiffness, N per degree of slip angle", "lateral", (t, s) => stiffness(t, s, 1, "stiffness")],
  ["Camber stiffness, N per degree of camber", "lateral", (t, s) => stiffness(t, s, t.parameters.side_force_ratio, "camber")],
  ["Side force without slip angle, N", "lateral", (t, s) => {
    const y = t.forces(0, 0, s.gamma, s.load, s.mu)[1];
    const why = Math.abs(y) >= 0.999 * t.circle(s.mu) * s.load ? "at the friction circle"
      : camberRidden(t, s.gamma) ? "the ride does not determine the stiffness" : "beyond the camber that was ridden";
    return [y, sideBand(t, 0, s.gamma, s.load, s.mu), 0, why];
  }],
  ["Radius of the friction circle, N", "longitudinal", (t, s) => {
    const bySide = Math.abs(t.parameters.mf_d) < t.parameters.lateral_peak, known = radiusKnown(t) && bounded(t, s);
    const why = bySide ? "by the side force that was ridden" : radiusKnown(t) ? FAR : "the peak friction is poorly determined";
    return [t.circle(s.mu) * s.load, known ? t.peak.map(size => size * s.mu * s.load) : null, 0, why];
  }],
];
const stiffness = (t, s, ratio, band) => {
  const per = s.load / DEGREES, y = ratio * t.kAlpha(s.gamma) * per, b = t.off(band, Math.abs(s.gamma));
  const leant = camberRidden(t, s.gamma);
  return [y, b && [b.low * per, b.high * per], 1, b ? "" : leant ? "the ride does not determine it" : "beyond the camber that was ridden"];
};
const tabulate = s => {
  const head = at("numbers-head"), body = at("numbers-body");
  head.replaceChildren(make("th", "", null, `At ${s.load} N, camber ${minus(controls.camber.value)}\u00b0, road ${s.mu}`));
  head.firstChild.scope = "col";
  for (const { tyre } of shown) for (const text of [tyre.name, "95 % interval"]) make("th", "n", head, text).scope = "col";
  body.replaceChildren(...NUMBERS.map(([label, half, of]) => {
    const row = make("tr");
    make("th", "", row, label).scope = "row";
    for (const { tyre } of shown) {
      const [y, b, digits, why, note] = tyre[half] ? of(tyre, s) : [null, null, 0, "not ridden"];
      if (y == null) {
        const cell = make("td", "why", row, why);
        cell.colSpan = 2;
        continue;
      }
      make("td", "n", row, minus(y.toFixed(digits))).dataset.label = tyre.name;
      make("td", b && !note ? "n nowrap" : "n", row, b ? span(y, b, digits) + (note ? `, ${note}` : "") : why || "\u2013").dataset.label = "95 % interval";
    }
    return row;
  }));
};

const SLIDERS = ["load", "camber", "mu", "angle", "slip"];
const refresh = () => {
  const s = setting(), view = VIEWS[controls.show.value], missing = [];
  for (const name of SLIDERS) {
    if (document.activeElement !== at(`${name}-now`)) at(`${name}-now`).value = controls[name].value;
    at(`${name}-row`).hidden = !view.uses.includes(name);
  }
  shown = chosen().flatMap((tyre, i) => tyre ? [{ tyre, colour: () => theme.lines[i === 0 ? 1 : 0] }] : []);
  shown.forEach((o, i) => {
    const why = lacks(o.tyre, view);
    if (why) missing.push(why);
    o.curves = why ? [] : view.value ? curveOf(o.tyre, view, s) : ellipseOf(o.tyre, s);
  });
  const why = shown.filter(o => view.why && !lacks(o.tyre, view) && view.why(o.tyre, s)).map(o => o.tyre.name);
  at("missing").textContent = unknown + missing.join(" ");
  unknown = "";
  at("caption").textContent = view.value
    ? `${view.y.label} over ${view.x.label}. Solid: as ridden; dashed: beyond it. Band: 95 % interval.${why.length ? ` No band at this load of ${why.join(" and ")}: it is ${FAR}, and how friction changes with load is assumed.` : ""}`
    : "Slip angles of 0, 1, 2, 4 and 8\u00b0, the slip ratio from locked to spinning. Dotted: friction circle, with the 95 % interval of its radius where that is known; the curves have none.";
  at("legend").replaceChildren(...shown.map(o => {
    const e = make("span"), mark = make("i", "line", e);
    mark.style.background = o.colour();
    e.append(o.tyre.name);
    return e;
  }));
  holder.setAttribute("aria-label", `${view.y.label} over ${view.x.label} of ${shown.map(o => o.tyre.name).join(" and ") || "no tyre"}`);
  build();
  tabulate(s);
  // the address is a link to what is shown
  const id = c => c.value === "" ? "" : data.tyres[+c.value].id;
  const link = new URLSearchParams({ a: id(controls.a), b: id(controls.b), ...Object.fromEntries(["show", ...SLIDERS].map(n => [n, controls[n].value])) });
  history.replaceState(null, "", `#${link}`);
};
const fromAddress = () => {
  const asked = new URLSearchParams(location.hash.slice(1));
  unknown = "";
  for (const side of ["a", "b"]) {
    const place = data.tyres.findIndex(t => t.id === asked.get(side));
    if (place >= 0) controls[side].value = String(place);
    else if (asked.has(side) && asked.get(side) !== "") unknown = `The tyre ${asked.get(side)} of the link is not among those of this page (the newest rides of each motorcycle). `;
    else if (asked.has(side)) controls[side].value = side === "a" ? "0" : "";
  }
  for (const name of ["show", ...SLIDERS]) {
    const before = controls[name].value;
    if (asked.has(name) && (name === "show" || Number.isFinite(Number(asked.get(name))))) controls[name].value = asked.get(name);
    if (controls[name].value === "") controls[name].value = before;
  }
  // both tyres of the first ride, where the link says nothing
  if (!asked.has("a") && data.tyres.length > 1 && data.tyres[1].parameters.session_id === data.tyres[0].parameters.session_id) controls.b.value = "1";
  if (!asked.has("load") && data.tyres.length) controls.load.value = String(10 * Math.round(chosen()[0].parameters.load_at_rest / 10));
};

const csv = () => {
  const view = VIEWS[controls.show.value];
  const of = { load: "load (N)", camber: "camber (deg)", mu: "road friction", slip: "slip ratio (%)", angle: "slip angle (deg)" };
  const given = Object.keys(of).filter(name => view.uses.includes(name) && of[name] !== headed(view.x));
  return rowsOf([
    ["tyre", "curve", headed(view.x), headed(view.y), "ci95_low", "ci95_high", "ridden", ...given.map(name => of[name])],
    ...shown.flatMap(o => o.curves.flatMap(c => c.points.map(p =>
      [o.tyre.name, c.name.replace("\u00b0", " deg"), p.x, p.y, p.low, p.high, p.ridden, ...given.map(name => controls[name].value)]))),
  ]);
};
at("csv").addEventListener("click", () => save(new Blob([csv()], { type: "text/csv" }), `tyre_${controls.show.value}.csv`));
const drawing = () => drawingOf(() => u, build, () => {
  const view = VIEWS[controls.show.value], value = name => minus(controls[name].value);
  const of = { load: `load ${value("load")} N`, camber: `camber ${value("camber")}\u00b0`, slip: `slip ratio ${value("slip")} %`, angle: `slip angle ${value("angle")}\u00b0`, mu: `road friction ${value("mu")}` };
  const given = Object.keys(of).filter(name => view.uses.includes(name) && view.x.label !== name);
  return {
    title: `${view.y.label} over ${view.x.label}: ${given.map(name => of[name]).join(", ")}`, note: at("caption").textContent,
    key: shown.map(o => [o.tyre.name, o.colour()]),
  };
});
at("svg").addEventListener("click", () => save(new Blob([drawing()], { type: "image/svg+xml" }), `tyre_${controls.show.value}.svg`));
at("png").addEventListener("click", () =>
  pictureOf(u, shown.map(o => o.tyre.name).join(" and ")).toBlob(blob => save(blob, `tyre_${controls.show.value}.png`)));
Object.assign(store, { csv, drawing }); // for tests and for the curious
store.intervals = { along: slipBand, across: sideBand };

readTheme();
data.tyres.forEach((t, i) => {
  for (const c of [controls.a, controls.b]) {
    let group = [...c.querySelectorAll("optgroup")].find(g => g.label === t.bike);
    if (!group) { group = make("optgroup", "", c); group.label = t.bike; }
    make("option", "", group, t.name).value = String(i);
  }
});
if (wrong) at("missing").textContent = "This browser computes the tyre otherwise than roadbench did: do not use these curves.";
else if (data.tyres.length) {
  fromAddress();
  for (const c of Object.values(controls)) c.addEventListener("input", refresh);
  // some aids say of a choice that it changed, and nothing of its input
  for (const c of [controls.show, controls.a, controls.b]) c.addEventListener("change", refresh);
  for (const name of SLIDERS) at(`${name}-now`).addEventListener("change", e => { e.target.value = controls[name].value; });
  for (const name of SLIDERS) at(`${name}-now`).addEventListener("input", e => {
    if (e.target.value === "" || !e.target.checkValidity()) return;
    controls[name].value = e.target.value;
    refresh();
  });
  // "#main" of the skip link is no link to a tyre
  addEventListener("hashchange", () => { if (location.hash.includes("a=")) { fromAddress(); refresh(); } });
  keys(holder, () => u, () => { tip.hide(); reset(u, home); }, () => {});
  follow(holder, () => u);
  refresh();
  addEventListener("beforeprint", () => { printing = true; root.dataset.print = ""; readTheme(); build(); });
  addEventListener("afterprint", () => { printing = false; delete root.dataset.print; readTheme(); build(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readTheme(); refresh(); });
}
