// Long tables: search, order, and pages of some rows. The first rows are in the table as it comes;
// all of them are in a script element beside it, as src/report/list.rs writes them: base64 of zlib of
// JSON, a row an array of cells, a cell a text or an object. No more rows are made than are shown.
// Texts reach the page through textContent alone.
(async () => {
  "use strict";
  if (!("DecompressionStream" in window)) return; // a browser before 2023 has the first rows
  const PRINTED = 1000;
  const narrow = matchMedia("(max-width: 640px)");
  // pages that were written after this one, by `roadbench report --open`
  const since = new Set(window.roadbenchPages || []);
  const unpack = async store => {
    const packed = Uint8Array.from(atob(store.textContent), c => c.charCodeAt(0));
    store.remove();
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).json();
  };
  const make = (tag, parent, text, name) => {
    const e = document.createElement(tag);
    if (text !== undefined) e.textContent = text;
    if (name) e.className = name;
    if (parent) parent.append(e);
    return e;
  };
  const plain = cell => typeof cell === "string" ? cell
    : cell.lines ? cell.lines.map(line => line[1].map(p => p.text).join(" ")).join(" ") : cell.text;
  const number = text => {
    const value = parseFloat(text.replace("\u2212", "-"));
    return isNaN(value) ? -Infinity : value;
  };
  const byKey = key => (a, b) => key[a] < key[b] ? -1 : key[a] > key[b] ? 1 : a - b;

  // how to write a page: the command, with the folder that this page lies in
  const demand = document.querySelector(".demand");
  const quoted = text => /^[\w./-]+$/.test(text) && text[0] !== "-" ? text : `'${text.replace(/'/g, "'\\''")}'`;
  const folder = () => {
    const path = decodeURIComponent(location.pathname).replace(/\/report\/[^/]*$/, "");
    return location.protocol === "file:" && path ? quoted(path) : "OUT";
  };
  const command = (session, bike) => {
    const code = demand.querySelector("code");
    code.textContent = `roadbench report ${folder()} --open=${quoted(session)} --bike=${quoted(bike)}`;
    getSelection().selectAllChildren(code);
    demand.scrollIntoView({ block: "nearest" });
  };

  const fill = (parent, cell, row) => {
    if (typeof cell === "string") parent.textContent = cell;
    else if (cell.lines)
      for (const [name, parts] of cell.lines) {
        const line = name ? make("span", parent, undefined, name) : parent;
        parts.forEach((p, i) => {
          if (i) line.append(" ");
          const part = p.class ? make("span", line, undefined, p.class) : line;
          if (p.href) make("a", part, p.text).href = p.href; else part.append(p.text);
        });
      }
    else if (cell.href && (cell.there || since.has(cell.href))) make("a", parent, cell.text).href = cell.href;
    else if (cell.href && demand) {
      const button = make("button", parent, cell.text, "pick");
      button.type = "button";
      button.title = "This page is not written yet: show the command that writes it";
      button.addEventListener("click", () => command(cell.text, plain(row[1])));
    } else parent.textContent = cell.text;
  };

  const long = async box => {
    const store = box.querySelector("script");
    if (!store) return;
    const region = box.querySelector(".scroll"), body = box.querySelector("tbody"), heads = [...box.querySelectorAll("thead th")];
    const rows = await unpack(store);
    const tools = make("p", undefined, undefined, "tools screen");
    const label = make("label", tools, "Search");
    const input = make("input", label);
    input.type = "search";
    input.autocomplete = "off";
    input.placeholder = box.dataset.words;
    const sorter = make("label", tools, "Sort", "sorter"), choice = make("select", sorter);
    make("option", choice, "as it is").value = "-1 1";
    heads.forEach((th, i) => {
      make("option", choice, `${th.textContent} ↑`).value = `${i} 1`;
      make("option", choice, `${th.textContent} ↓`).value = `${i} -1`;
    });
    const told = make("output", tools);
    const button = (text, title) => {
      const b = make("button", tools, text);
      b.type = "button";
      b.title = title;
      return b;
    };
    const first = button("First", "Home"), back = button("Previous", "Page Up");
    const on = button("Next", "Page Down"), last = button("Last", "End");
    box.prepend(tools);

    const all = rows.map((_, i) => i), keys = new Map();
    let found = all, from = 0, texts = null, by = -1, sign = 1;
    const page = () => narrow.matches ? Math.min(20, +box.dataset.page) : +box.dataset.page;
    const row = i => {
      const tr = document.createElement("tr");
      rows[i].forEach((cell, k) => {
        const e = make(k ? "td" : "th", tr, undefined, heads[k].className);
        if (!k) e.scope = "row";
        else if (heads[k].dataset.label && cell !== "") e.dataset.label = heads[k].dataset.label;
        fill(e, cell, rows[i]);
      });
      return tr;
    };
    const put = some => body.replaceChildren(...some.map(row));
    const show = () => {
      const size = page(), to = Math.min(from + size, found.length);
      put(found.slice(from, to));
      told.textContent = found.length ? `${from + 1} to ${to} of ${found.length}` : "none";
      first.disabled = back.disabled = from === 0;
      on.disabled = last.disabled = to >= found.length;
      for (const b of [first, back, on, last]) b.hidden = found.length <= size;
    };
    const go = to => {
      const size = page(), end = Math.max(0, Math.ceil(found.length / size) - 1) * size;
      const inside = box.contains(document.activeElement);
      from = Math.max(0, Math.min(to, end));
      show();
      // the focus was in a row that went, or on a button that has nothing more to do: it stays here
      const now = document.activeElement;
      if (inside && (!box.contains(now) || now.disabled)) region.focus({ preventScroll: true });
    };
    const key = k => {
      if (!keys.has(k)) {
        const read = heads[k].classList.contains("n")
          ? cell => cell.key ?? number(plain(cell))
          : cell => plain(cell).toLowerCase();
        keys.set(k, rows.map(r => read(r[k])));
      }
      return keys.get(k);
    };
    const search = () => {
      const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      if (wanted.length) texts ??= rows.map(r => r.map(plain).join(" ").toLowerCase());
      found = wanted.length ? all.filter(i => wanted.every(w => texts[i].includes(w))) : [...all];
      if (by >= 0) {
        found.sort(byKey(key(by)));
        if (sign < 0) found.reverse();
      }
      go(0);
    };
    const order = (k, way) => {
      by = k;
      sign = way;
      choice.value = `${k} ${way}`;
      heads.forEach((th, i) => {
        if (i === k) th.setAttribute("aria-sort", way > 0 ? "ascending" : "descending");
        else th.removeAttribute("aria-sort");
      });
      search();
    };
    heads.forEach((th, k) => {
      const b = make("button", undefined, th.textContent, "sort");
      b.type = "button";
      th.replaceChildren(b);
      // numbers: the largest first
      const usual = th.classList.contains("n") ? -1 : 1;
      b.addEventListener("click", () => order(k, by === k ? -sign : usual));
    });
    choice.addEventListener("change", () => order(...choice.value.split(" ").map(Number)));
    input.addEventListener("input", search);
    first.addEventListener("click", () => go(0));
    back.addEventListener("click", () => go(from - page()));
    on.addEventListener("click", () => go(from + page()));
    last.addEventListener("click", () => go(found.length));
    box.addEventListener("keydown", e => {
      const typing = e.target === input || e.target === choice;
      const to = e.key === "PageDown" ? from + page() : e.key === "PageUp" ? from - page()
        : typing ? null : e.key === "Home" ? 0 : e.key === "End" ? found.length : null;
      if (to == null || e.altKey || e.ctrlKey || e.metaKey) return;
      e.preventDefault();
      go(to);
    });
    narrow.addEventListener("change", () => go(from));
    addEventListener("beforeprint", () => put(found.slice(0, PRINTED)));
    addEventListener("afterprint", show);
    show();
  };
  for (const box of document.querySelectorAll(".long")) await long(box);
})();
