// The list of sessions on the run's page: a filter, and pages of a hundred where there are many.
// Without a script the whole list is there.
(() => {
  "use strict";
  const PAGE = 100;
  const body = document.getElementById("session-rows"), tools = document.getElementById("session-tools");
  if (!body || !tools) return;
  const rows = [...body.rows].map(row => ({ row, text: row.textContent.toLowerCase() }));
  if (rows.length < 12) return;
  tools.hidden = false;
  const input = tools.querySelector("input"), told = tools.querySelector("output");
  const [back, on] = tools.querySelectorAll("button");
  let found = rows, from = 0;
  const show = () => {
    body.replaceChildren(...found.slice(from, from + PAGE).map(r => r.row));
    const last = Math.min(from + PAGE, found.length);
    told.textContent = found.length ? `${from + 1} to ${last} of ${found.length}` : "none";
    back.disabled = from === 0;
    on.disabled = last >= found.length;
    back.hidden = on.hidden = found.length <= PAGE;
  };
  input.addEventListener("input", () => {
    const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    found = rows.filter(r => wanted.every(w => r.text.includes(w)));
    from = 0;
    show();
  });
  back.addEventListener("click", () => { from = Math.max(0, from - PAGE); show(); });
  on.addEventListener("click", () => { from += PAGE; show(); });
  addEventListener("beforeprint", () => body.replaceChildren(...found.map(r => r.row)));
  addEventListener("afterprint", show);
  show();
})();
