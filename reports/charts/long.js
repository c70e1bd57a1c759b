// Long tables of the run's page: a filter, and pages of a hundred rows. The first hundred are in the
// table; what follows stands in a <noscript>, which a browser with scripts does not lay out: ten
// thousand rows would take it seconds. Without a script the whole list is there, in two tables.
(() => {
  "use strict";
  const PAGE = 100;
  const tools = `<label>Filter <input type="search" autocomplete="off"></label> <output></output>
    <button type="button">Previous</button> <button type="button">Next</button>`;
  // what a row says, without its markup
  const plain = html => {
    const text = document.createElement("textarea");
    text.innerHTML = html.replace(/<[^>]*>/g, " ");
    return text.value.toLowerCase();
  };
  for (const box of document.querySelectorAll(".long")) {
    const body = box.querySelector("tbody"), rest = box.querySelector("noscript");
    const rows = [...body.rows].map(row => row.outerHTML);
    if (rest) rows.push(...rest.textContent.match(/<tr[^]*?<\/tr>/g).slice(1)); // less its head
    if (rows.length < 12) continue;
    const head = document.createElement("p");
    head.className = "tools screen";
    head.innerHTML = tools;
    const input = head.querySelector("input"), told = head.querySelector("output");
    input.placeholder = box.dataset.words;
    const [back, on] = head.querySelectorAll("button");
    box.prepend(head);
    let found = rows, from = 0, texts = null;
    const put = some => { body.innerHTML = some.join(""); };
    const tell = () => {
      const last = Math.min(from + PAGE, found.length);
      told.textContent = found.length ? `${from + 1} to ${last} of ${found.length}` : "none";
      back.disabled = from === 0;
      on.disabled = last >= found.length;
      back.hidden = on.hidden = found.length <= PAGE;
    };
    const show = () => { put(found.slice(from, from + PAGE)); tell(); };
    input.addEventListener("input", () => {
      const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      texts ??= rows.map(plain);
      found = rows.filter((_, i) => wanted.every(w => texts[i].includes(w)));
      from = 0;
      show();
    });
    back.addEventListener("click", () => { from = Math.max(0, from - PAGE); show(); });
    on.addEventListener("click", () => { from += PAGE; show(); });
    addEventListener("beforeprint", () => put(found));
    addEventListener("afterprint", show);
    tell();
  }
})();
