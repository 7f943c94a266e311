// SPDX-License-Identifier: Apache-2.0
// What plots have beside Chart.js's lines: where phases begin, and the dots of fixes.

// Dashed where a phase begins.
Chart.register({
  id: "phases",
  beforeDatasetsDraw({ctx, chartArea: area, scales: {x}}) {
    ctx.save();
    ctx.strokeStyle = color("soft");
    ctx.globalAlpha = 0.45;
    ctx.setLineDash([2, 3]);
    ctx.beginPath();
    for (const {t_s} of phasesOf(flight).slice(1)) {
      const at = Math.round(x.getPixelForValue(t_s)) + 0.5;
      if (at < area.left || at > area.right) continue;
      ctx.moveTo(at, area.top), ctx.lineTo(at, area.bottom);
    }
    ctx.stroke();
    ctx.restore();
  },
});

// Of a dataset with dotted: so many dots that none touches another; a fix that is off keeps its own.
const dotRadius = 1.9, apart = 5;  // pixels
Chart.register({
  id: "dots",
  afterDatasetsDraw({ctx, data, chartArea: area, scales: {x, y}}) {
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
    ctx.clip();
    for (const dataset of data.datasets.filter(({dotted}) => dotted)) {
      ctx.fillStyle = dataset.borderColor;
      ctx.beginPath();
      let last_x = -Infinity, last_y = 0;
      for (const point of dataset.data) {
        if (!Number.isFinite(point.y)) continue;
        const at_x = x.getPixelForValue(point.x), at_y = y.getPixelForValue(point.y);
        if (Math.hypot(at_x - last_x, at_y - last_y) < apart) continue;
        ctx.moveTo(at_x + dotRadius, at_y);
        ctx.arc(at_x, at_y, dotRadius, 0, 2 * Math.PI);
        [last_x, last_y] = [at_x, at_y];
      }
      ctx.fill();
    }
    ctx.restore();
  },
});
