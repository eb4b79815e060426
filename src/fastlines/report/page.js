// A click on a head sorts its table by that column; cells without a value go last.
"use strict";
for (const head of document.querySelectorAll("table.sortable thead th")) {
  head.querySelector("button").addEventListener("click", () => {
    const table = head.closest("table"), body = table.tBodies[0], column = head.cellIndex;
    const up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of head.parentNode.cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const numbers = [...body.rows].some(row => row.cells[column].dataset.value !== undefined);
    const order = (a, b) => {
      const x = a.cells[column], y = b.cells[column];
      if (!numbers) return (up ? 1 : -1) * x.textContent.localeCompare(y.textContent);
      const known = [x, y].map(cell => cell.dataset.value !== undefined);
      if (!known[0] || !known[1]) return known[1] - known[0];
      return (up ? 1 : -1) * (x.dataset.value - y.dataset.value);
    };
    body.append(...[...body.rows].sort(order));
  });
}
