// Sections that fold: a link to one, or to something inside it, opens it; paper has all of them open.
(() => {
  "use strict";
  const folded = ":scope > details.fold";
  const unfold = () => {
    let to = null;
    try { to = document.getElementById(decodeURIComponent(location.hash.slice(1))); } catch { return; }
    if (!to) return;
    for (let e = to.querySelector(folded) || to; e; e = e.parentElement)
      if (e.tagName === "DETAILS") e.open = true;
    to.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  // a link to where the address already is changes nothing in it
  document.addEventListener("click", e => {
    const link = e.target.closest && e.target.closest('a[href^="#"]');
    if (link && link.hash === location.hash) setTimeout(unfold);
  });
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details.fold:not([open])")];
    closed.forEach(e => { e.open = true; });
  });
  addEventListener("afterprint", () => closed.forEach(e => { e.open = false; }));
  unfold();
})();
