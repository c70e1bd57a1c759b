// Pictures as SVG that stand alone: what a chart draws on its canvas is taken down as elements, in the colours of paper.
// The namespace is asked of the browser: pages have no addresses in them.
const SVG = (() => {
  const template = document.createElement("template");
  template.innerHTML = "<svg></svg>";
  return template.content.firstChild.namespaceURI;
})();
const element = (tag, parent, attributes, text) => {
  const e = document.createElementNS(SVG, tag);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  if (text !== undefined) e.textContent = text;
  if (parent) parent.append(e);
  return e;
};
const FAMILY = 'system-ui, "Segoe UI", "Liberation Sans", "DejaVu Sans", Arial, Helvetica, sans-serif';
const short = v => +v.toFixed(2);
// in two parts: a page has nothing in it that reads like something to be fetched
const reference = id => "url" + `(#${id})`;
const OUTLINES = {
  moveTo: (x, y) => `M${short(x)} ${short(y)}`,
  lineTo: (x, y) => `L${short(x)} ${short(y)}`,
  closePath: () => "Z",
  rect: (x, y, w, h) => `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}Z`,
  bezierCurveTo: (...v) => `C${v.map(short).join(" ")}`,
  // charts draw whole circles alone
  arc: (x, y, r) => `M${short(x - r)} ${short(y)}a${short(r)} ${short(r)} 0 1 0 ${short(2 * r)} 0a${short(r)} ${short(r)} 0 1 0 ${short(-2 * r)} 0Z`,
};
// a path that begins with a line begins there, on a canvas alone
const added = (d, outline) => d ? d + outline : outline.replace(/^L/, "M");
// a colour as every program of drawings reads it, and its opacity
const solid = colour => {
  const [, r, g, b, a] = /^rgba?\((\d+), ?(\d+), ?(\d+)(?:, ?([\d.e-]+))?\)$/.exec(colour) || [];
  return r === undefined ? [colour, 1] : [`#${[r, g, b].map(v => (+v).toString(16).padStart(2, "0")).join("")}`, a === undefined ? 1 : +a];
};
const ANCHORS = { center: "middle", right: "end", end: "end" };
const BASELINES = { top: 0.8, hanging: 0.8, middle: 0.33, bottom: -0.22, ideographic: -0.22 };

// Takes down what is drawn until it is stopped: `of` a context the elements since it was last cleared.
const taking = () => {
  const proto = CanvasRenderingContext2D.prototype, real = {}, takes = new Map(), Path = window.Path2D;
  const of = ctx => {
    if (!takes.has(ctx)) takes.set(ctx, { body: element("g", null, {}), defs: element("defs", null, {}), clip: null, saved: [], d: "", ids: 0 });
    return takes.get(ctx);
  };
  const common = (ctx, take) => {
    const m = ctx.getTransform(), out = {};
    if (!m.isIdentity) out.transform = `matrix(${[m.a, m.b, m.c, m.d, m.e, m.f].map(v => +v.toFixed(4)).join(" ")})`;
    if (take.clip) out["clip-path"] = reference(take.clip);
    return out;
  };
  const paint = (ctx, take, kind) => {
    const style = ctx[`${kind}Style`];
    if (typeof style !== "string") {
      const id = `p${++take.ids}`, n = 6 * (devicePixelRatio || 1);
      const tile = element("pattern", take.defs, { id, width: n, height: n, patternUnits: "userSpaceOnUse" });
      element("path", tile, { d: `M0 ${n}L${n} 0`, stroke: style.colour || theme.soft, "stroke-opacity": 0.5, "stroke-width": n / 6 });
      return { [kind]: reference(id) };
    }
    const [colour, own] = solid(style), opacity = own * ctx.globalAlpha;
    return { [kind]: colour, ...(opacity < 1 ? { [`${kind}-opacity`]: +opacity.toFixed(3) } : {}) };
  };
  const stroked = (ctx, take) => ({
    ...paint(ctx, take, "stroke"), "stroke-width": short(ctx.lineWidth),
    ...(ctx.lineJoin !== "miter" ? { "stroke-linejoin": ctx.lineJoin } : {}),
    ...(ctx.lineCap !== "butt" ? { "stroke-linecap": ctx.lineCap } : {}),
    ...(ctx.getLineDash().length ? { "stroke-dasharray": ctx.getLineDash().map(short).join(" ") } : {}),
  });
  const shape = (ctx, kind, d) => {
    const take = of(ctx);
    if (!d) return;
    const how = kind === "fill" ? paint(ctx, take, "fill") : { fill: "none", ...stroked(ctx, take) };
    // of what is not seen nothing is kept
    if (how[`${kind}-opacity`] < 0.02) return;
    element("path", take.body, { d, ...how, ...common(ctx, take) });
  };
  const text = (ctx, words, x, y) => {
    const take = of(ctx), [, weight, size] = /(?:\b(bold|\d00) )?([\d.]+)px/.exec(ctx.font), down = (BASELINES[ctx.textBaseline] || 0) * size;
    const anchor = ANCHORS[ctx.textAlign];
    element("text", take.body, {
      x: short(x), y: short(y + down), "font-size": +size, ...(weight ? { "font-weight": weight } : {}), ...(anchor ? { "text-anchor": anchor } : {}),
      ...paint(ctx, take, "fill"), ...common(ctx, take),
    }, words);
  };
  const taken = {
    beginPath: ctx => { of(ctx).d = ""; },
    clearRect: ctx => { const take = of(ctx); take.body.replaceChildren(); take.defs.replaceChildren(); },
    save: ctx => of(ctx).saved.push(of(ctx).clip),
    restore: ctx => { of(ctx).clip = of(ctx).saved.pop() ?? null; },
    clip: (ctx, path) => {
      const take = of(ctx), id = `c${++take.ids}`, { transform, ...outer } = common(ctx, take);
      const clip = element("clipPath", take.defs, { id, ...outer });
      element("path", clip, { d: path && path.d !== undefined ? path.d : take.d, ...(transform ? { transform } : {}) });
      take.clip = id;
    },
    fill: (ctx, path) => shape(ctx, "fill", path && path.d !== undefined ? path.d : of(ctx).d),
    stroke: (ctx, path) => shape(ctx, "stroke", path && path.d !== undefined ? path.d : of(ctx).d),
    fillRect: (ctx, ...box) => shape(ctx, "fill", OUTLINES.rect(...box)),
    strokeRect: (ctx, ...box) => shape(ctx, "stroke", OUTLINES.rect(...box)),
    fillText: text,
  };
  for (const [name, outline] of Object.entries(OUTLINES)) taken[name] = (ctx, ...v) => { of(ctx).d = added(of(ctx).d, outline(...v)); };
  for (const [name, take] of Object.entries(taken)) {
    real[name] = proto[name];
    proto[name] = function (...v) { take(this, ...v); return real[name].apply(this, v); };
  }
  window.Path2D = class extends Path {
    constructor(from) { super(...(from === undefined ? [] : [from])); this.d = from && from.d || ""; }
  };
  for (const [name, outline] of Object.entries(OUTLINES))
    window.Path2D.prototype[name] = function (...v) { this.d = added(this.d, outline(...v)); return Path.prototype[name].apply(this, v); };
  const stop = () => { Object.assign(proto, real); window.Path2D = Path; };
  return { of, stop };
};

// What stands above a drawing: title, what the colours are, a note. Its height; lines that are too long go on below.
const headOf = (svg, width, px, { title, key, note }) => {
  const ctx = make("canvas").getContext("2d");
  let y = 0;
  const measured = (words, weight, size) => { ctx.font = `${weight} ${size}px ${FAMILY}`; return ctx.measureText(words).width; };
  const broken = (words, weight, size) => {
    const lines = [];
    for (const word of words.split(" ")) {
      const longer = lines.length ? `${lines[lines.length - 1]} ${word}` : word;
      if (lines.length && measured(longer, weight, size) <= width - 16 * px) lines[lines.length - 1] = longer; else lines.push(word);
    }
    return lines;
  };
  const put = (words, weight, size, fill) => broken(words, weight, size).forEach(line => {
    y += size * 1.45;
    element("text", svg, { x: 8 * px, y: short(y), "font-size": size, "font-weight": weight, fill }, line);
  });
  if (title) put(title, 600, 13 * px, theme.ink);
  let x = 8 * px;
  if (key && key.length) {
    y += 19 * px;
    for (const [label, colour] of key) {
      const size = 12 * px, wide = 20 * px + measured(label, 400, size);
      if (x > 8 * px && x + wide > width - 8 * px) { x = 8 * px; y += 18 * px; }
      element("path", svg, { d: `M${short(x)} ${short(y - 4 * px)}h${14 * px}`, stroke: colour, "stroke-width": 3 * px });
      element("text", svg, { x: short(x + 19 * px), y: short(y), "font-size": size, fill: theme.ink }, label);
      x += wide + 16 * px;
    }
  }
  if (note) put(note, 400, 11 * px, theme.soft);
  return y ? y + 8 * px : 0;
};
// A drawing on white paper, as text; `parts` are put below one another.
const sheetOf = (title, width, height, px, head, parts) => {
  const svg = element("svg", null, { role: "img", "font-family": FAMILY });
  element("title", svg, {}, title);
  const paper = element("rect", svg, { x: 0, y: 0, fill: "#ffffff" }), top = headOf(svg, width, px, head), all = height + top;
  const moved = element("g", svg, { transform: `translate(0 ${short(top)})` });
  moved.append(...parts);
  for (const [k, v] of [["width", width], ["height", all]]) { paper.setAttribute(k, short(v)); svg.setAttribute(k, short(v / px)); }
  for (const kind of ["fill", "stroke"]) for (const e of svg.querySelectorAll(`[${kind}^="rgb"]`)) {
    const [colour, opacity] = solid(e.getAttribute(kind));
    e.setAttribute(kind, colour);
    if (opacity < 1) e.setAttribute(`${kind}-opacity`, opacity);
  }
  svg.setAttribute("viewBox", `0 0 ${short(width)} ${short(all)}`);
  return new XMLSerializer().serializeToString(svg);
};
// The page in the colours of paper while something is drawn.
const onPaper = draw => {
  root.dataset.print = "";
  readTheme();
  try { return draw(); } finally {
    if (!printing) delete root.dataset.print;
    readTheme();
  }
};
// A chart as it is shown; `rebuild` makes it anew in the theme that is set.
const drawingOf = (current, rebuild, head) => {
  const { x, y } = current().scales, view = { x: [x.min, x.max], y: [y.min, y.max] };
  const again = () => { rebuild(); reset(current(), view); };
  try {
    return onPaper(() => {
      const take = taking();
      try { again(); } finally { take.stop(); }
      const { ctx } = current(), { body, defs } = take.of(ctx), said = head();
      return sheetOf(said.title, ctx.canvas.width, ctx.canvas.height, devicePixelRatio || 1, said, [defs, body]);
    });
  } finally { again(); }
};
