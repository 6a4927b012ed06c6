// Charts with their controls and legends, and the table of a page of results. ECharts draws.
const data = JSON.parse(document.getElementById('data').textContent);
const root = document.documentElement;
const FONT = { fontSize: 12, fontFamily: 'system-ui, sans-serif' };
const drawings = []; // functions that draw a chart anew
const finite = (value) => value !== null && value !== undefined;
const digits = (value, count = 4) => String(Number(value.toPrecision(count)));
/** Return a colour of the style sheet, or the CSS colour itself. */
const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim() || name;
const shade = (share) => (finite(share) ? `hsl(${270 - 150 * share}, 50%, 50%)` : colour('faint'));

/** Return a series of the shapes that `draw(place, point, area)` makes of points [x, ...]. */
const shapes = (name, points, draw, z) => ({
  type: 'custom', name, data: points, silent: true, clip: true, z, tooltip: { show: false },
  encode: { x: 0, y: points[0]?.length > 2 ? [1, 2] : [] },
  renderItem: (at, api) => draw((x, y) => api.coord([x, y]), points[at.dataIndex], at.coordSys),
});

/** Draw vertical bars [x, low, high]. */
const bars = (name, points, stroke, lineWidth, opacity, z) =>
  shapes(name, points.filter((p) => finite(p[1])), (place, [x, low, high]) => {
    const [[x1, y1], [x2, y2]] = [place(x, low), place(x, high)];
    return { type: 'line', shape: { x1, y1, x2, y2 }, style: { stroke, lineWidth, opacity } };
  }, z);

/** Draw a band [x, low, high], as bars if points lack one. */
function band(points, fill) {
  const isWhole = points.length > 1 && points.every((p) => finite(p[1]));
  if (!isWhole) return bars('band', points, fill, 5, 0.35, 0);
  return shapes('band', points, (place, point) => {
    if (point !== points[0]) return null;
    const upper = points.map(([x, , high]) => place(x, high));
    const lower = points.map(([x, low]) => place(x, low)).reverse();
    const shape = { points: [...upper, ...lower] };
    return { type: 'polygon', shape, style: { fill, opacity: 0.18 } };
  }, 0);
}

/** Write a text at places on the x axis: x, text, and the part of the height above it. */
const texts = (points, fill, high) => ({ ...shapes('text', points, (place, [x, text], area) => {
  const [left, y] = [place(x, 1)[0], area.y + (high ? 0 : area.height)];
  const style = { ...FONT, text, fill, align: 'center', verticalAlign: high ? 'top' : 'bottom' };
  const isInside = left > area.x - 1 && left < area.x + area.width + 1;
  return isInside ? { type: 'text', x: left, y, style } : null;
}, 4), clip: false });

/** Mark the spectral lines [frequency, name]; names that would overlap are left out. */
function marks(points, area) {
  const named = points.filter((p) => p[1]);
  const step = Math.ceil(named.length / Math.max(1, area / 105));
  const stroke = { stroke: colour('faint'), lineWidth: 1, lineDash: [2, 3] };
  return [
    shapes('marks', points, (place, [x], { y, height }) => {
      const x1 = place(x, 1)[0];
      return { type: 'line', shape: { x1, y1: y, x2: x1, y2: y + height }, style: stroke };
    }, 0),
    texts(named.filter((_, i) => i % step === 0), colour('faint'), true),
  ];
}

/** Return the series of one curve: its band, healthy level, error bounds, marks and line. */
function curveOf(chart, panel, curve, x, list, healthy, shares) {
  const at = (key, i) => panel.columns[key]?.[i];
  const rows = (indices, ...keys) => indices.map((i) => [x[i], ...keys.map((k) => at(k, i))]);
  const [stroke, { curves, points: { mark, owner } }] = [colour(curve.colour), chart];
  const known = list.filter((i) => finite(at('y', i)));
  const bounds = known.filter((i) => finite(at('error', i)))
    .map((i) => [x[i], at('y', i) - at('error', i), at('y', i) + at('error', i)]);
  const still = { silent: true, tooltip: { show: false }, symbol: 'none', z: 1 };
  return [
    band(rows(list, 'low', 'high'), stroke),
    bars('error', bounds, stroke, 1.5, 1, 3),
    texts(list.filter((i) => mark?.[i]).map((i) => [x[i], mark[i]]), colour('lost')),
    { type: 'line', name: 'healthy', data: rows(list, 'healthy').filter((p) => finite(p[1])),
      ...still, lineStyle: { color: healthy ? colour('faint') : stroke, width: 1, type: [4, 3] } },
    { type: 'scatter', name: 'chaotic', data: rows(known.filter((i) => at('chaotic', i)), 'y'),
      ...still, symbol: 'circle', symbolSize: 16,
      itemStyle: { color: 'transparent', borderColor: colour('faint'), borderWidth: 1.5 } },
    { type: ['points', 'design'].includes(chart.kind) ? 'scatter' : 'line', name: curve.name,
      data: list.map((i) => ({ value: [x[i], at('y', i) ?? null], point: i,
        ...(shares && { itemStyle: { color: shade(shares[i]) } }),
        ...(finite(owner?.[i]) && { itemStyle: { color: colour(curves[owner[i]].colour) } }) })),
      color: stroke, z: 2, emphasis: { disabled: true }, showAllSymbol: true, symbolSize: 7,
      symbol: chart.kind === 'signal' ? 'none' : curve.symbol,
      lineStyle: { color: stroke, width: curve.measured ? 0 : chart.kind === 'signal' ? 1 : 2,
        type: curve.dash.length ? curve.dash : 'solid' } },
  ];
}

/** Return the series of a panel. */
function seriesOf(chart, panel, { x, lists, hidden, shares, trend, width }) {
  const level = (list) => `${list.map((i) => [x[i], panel.columns.healthy?.[i]])}`;
  const simulated = lists.filter((list, k) => list.length && !chart.curves[k].measured);
  const shared = new Set(simulated.map(level)).size < 2;
  const drawn = chart.curves.map((curve, k) => [curve, lists[k]])
    .filter(([curve, list]) => list.length && !hidden.has(curve));
  const groups = panel.trends[trend] ?? [];
  const line = { type: 'line', name: 'median', symbol: 'none', silent: true, z: 3,
    data: groups.map((g) => [g[0], g[2]]), lineStyle: { color: colour('ink'), width: 2 } };
  return [
    ...drawn.flatMap(([curve, list]) => curveOf(chart, panel, curve, x, list, shared, shares)),
    ...(groups.length ? [band(groups.map((g) => [g[0], g[1], g[3]]), colour('ink')), line] : []),
    ...(chart.marks.length ? marks(chart.marks, width) : []),
  ];
}

/** Return the text over points at one place on the x axis. */
function tooltip(panel, axis, items) {
  const at = (key, i) => panel.columns[key]?.[i];
  const lines = items.filter((item) => finite(item.data.point)).map((item) => {
    const i = item.data.point;
    const bound = finite(at('error', i)) ? ` ± ${digits(at('error', i), 2)}` : '';
    const [low, high] = [at('low', i), at('high', i)];
    const unknown = panel.columns.low ? ' (range unknown)' : '';
    const range = finite(low) ? ` (${digits(low)} to ${digits(high)})` : unknown;
    const value = finite(at('y', i)) ? digits(at('y', i)) : 'no value';
    const name = item.seriesName && `${item.seriesName}: `;
    return `${name}${value}${bound} ${panel.unit}${range}${at('chaotic', i) ? ', chaotic' : ''}`;
  });
  const place = items[0]?.value?.[0];
  const text = axis.words.length ? axis.words[place] : finite(place) && digits(place, 9);
  return lines.length ? [`${axis.label}: ${text}`, ...lines].join('\n') : '';
}

/** Return the options of ECharts for a panel. */
function optionOf(chart, panel, axis, view) {
  const text = { ...FONT, color: colour('ink') };
  const lines = { lineStyle: { color: colour('faint') } };
  const values = view.lists.flat().map((i) => panel.columns.y[i]).filter(finite);
  const style = { axisLabel: { ...text, hideOverlap: true }, nameTextStyle: text,
    axisTick: lines, axisLine: { ...lines, onZero: false },
    splitLine: { lineStyle: { color: colour('line') } } };
  const turned = axis.words.join('').length * 7 > 0.6 * view.width ? 30 : 0;
  const all = { ...style.axisLabel, interval: 0, rotate: turned };
  const words = { type: 'category', data: axis.words, axisLabel: all };
  const numbers = (log, { label, ...ends }) => ({ type: log ? 'log' : 'value', ...ends,
    axisLabel: { ...style.axisLabel, ...label, formatter: (value) => digits(value, 6) } });
  const pad = chart.kind === 'line' && !axis.log ? 0.02 : 0; // points lie off the frame
  const tight = ['line', 'signal'].includes(chart.kind) ? {
    min: (x) => x.min - pad * (x.max - x.min), max: (x) => x.max + pad * (x.max - x.min),
    label: { showMinLabel: !pad, showMaxLabel: axis.log } } : {};
  const ends = panel.axis.phase ? { min: -180, max: 180, interval: 90 }
    : { scale: values.some((value) => value < 0) };
  return {
    animation: false, textStyle: text,
    aria: { enabled: true, label: { description: `${panel.axis.label}; x: ${axis.label}` } },
    grid: { left: 4, right: 22, top: 10, bottom: 24, containLabel: true },
    xAxis: { ...style, scale: true, ...(axis.words.length ? words : numbers(axis.log, tight)),
      name: axis.label, nameLocation: 'middle', nameGap: turned ? 60 : 26 },
    yAxis: { ...style, ...numbers(panel.axis.log, ends) },
    dataZoom: [{ type: 'inside', filterMode: 'none', zoomOnMouseWheel: 'ctrl',
      moveOnMouseWheel: false, moveOnMouseMove: 'shift', preventDefaultMouseMove: false }],
    tooltip: { trigger: chart.kind === 'design' ? 'item' : 'axis', renderMode: 'richText',
      confine: true, textStyle: text, backgroundColor: colour('paper'),
      borderColor: colour('faint'), formatter: (items) => tooltip(panel, axis, [items].flat()) },
    series: seriesOf(chart, panel, view),
  };
}

/** Return the computed setting with value `v` of control `k` that differs least from another. */
function nearest(chart, setting, k, v) {
  const differing = (key) => key.filter((value, i) => value !== setting[i]).length;
  return chart.combinations.filter((key) => key[k] === v)
    .reduce((best, key) => (differing(key) < differing(best) ? key : best));
}

/** Draw a chart, and connect its controls, its legend and its keys. */
function start(section) {
  const chart = data.charts[section.dataset.chart];
  const hidden = new Set();
  const controls = [...section.querySelectorAll('.controls label')];
  const boxes = [...section.querySelectorAll('.plot')];
  const plots = boxes.map((box) => echarts.init(box, null, { renderer: 'svg' }));
  let setting = chart.controls.map((control) => control.start);
  const draw = () => {
    const wanted = chart.combinations.findIndex((key) => `${key}` === `${setting}`);
    const all = [...chart.x[0].keys()];
    const lists = chart.shades.length ? [all] : chart.curves.map((_, k) => all.filter((i) =>
      chart.points.curve[i] === k && chart.points.combination[i] === wanted));
    const [trend, shares] = [chart.axes.length > 1 ? setting[0] : 0, chart.shades[setting[1] - 1]];
    plots.forEach((plot, k) => {
      plot.resize({ width: 'auto', height: 'auto' });
      const view = { x: chart.x[trend], lists, hidden, shares, trend, width: plot.getWidth() };
      plot.setOption(optionOf(chart, chart.panels[k], chart.axes[trend], view), { notMerge: true });
    });
    controls.forEach((label, k) => {
      const text = chart.controls[k].options[setting[k]];
      label.querySelector('input, select').value = setting[k];
      label.querySelector('input')?.setAttribute('aria-valuetext', text);
      label.querySelector('output').textContent = text;
    });
  };
  for (const [k, label] of controls.entries()) label.addEventListener('input', (event) => {
    setting = nearest(chart, setting, k, Number(event.target.value));
    draw();
  });
  const inputs = section.querySelectorAll('.legend input');
  for (const [k, input] of inputs.entries()) input.addEventListener('change', () => {
    hidden[input.checked ? 'delete' : 'add'](chart.curves[k]);
    draw();
  });
  plots.forEach((plot, k) => {
    const zoom = (start) => plot.dispatchAction({ type: 'dataZoom', start, end: 100 - start });
    boxes[k].addEventListener('dblclick', () => zoom(0));
    const keys = { '+': 25, '-': 0 };
    boxes[k].addEventListener('keydown', ({ key }) => key in keys && zoom(keys[key]));
  });
  drawings.push(draw);
  draw();
}

/** Sort, filter and copy the table. */
function table() {
  const body = document.querySelector('#table tbody');
  const rows = [...body.rows];
  const cell = (row, i) => row.cells[i].textContent;
  const heads = [...document.querySelectorAll('#table th')];
  for (const [i, head] of heads.entries()) head.addEventListener('click', () => {
    const sign = head.ariaSort === 'ascending' ? -1 : 1;
    const number = head.matches('.number') ? Number.parseFloat : () => 0; // not of an id
    const order = (a, b) => number(a) - number(b) || a.localeCompare(b);
    for (const other of heads) other.ariaSort = 'none';
    head.ariaSort = sign > 0 ? 'ascending' : 'descending';
    body.append(...rows.sort((a, b) => sign * order(cell(a, i), cell(b, i))));
  });
  document.getElementById('filter').addEventListener('input', (event) => {
    const words = event.target.value.toLowerCase().split(' ');
    const lacks = (row) => words.some((word) => !row.textContent.toLowerCase().includes(word));
    for (const row of rows) row.hidden = lacks(row);
  });
  document.getElementById('copy').addEventListener('click', async () => {
    const quoted = (c) => `"${c.textContent.trim().replaceAll('"', '""')}"`;
    const lines = [heads, ...rows.filter((row) => !row.hidden).map((row) => [...row.cells])];
    await navigator.clipboard.writeText(lines.map((c) => c.map(quoted).join(',')).join('\n'));
    document.getElementById('copied').textContent = `${lines.length - 1} rows copied`;
  });
}
for (const section of document.querySelectorAll('[data-chart]')) start(section);
table();
const redraw = () => { for (const draw of drawings) draw(); };
function print(on) {
  root.classList.toggle('print', on);
  for (const details of document.querySelectorAll('details')) details.open = on;
  redraw();
}
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
addEventListener('resize', redraw);
addEventListener('beforeprint', () => print(true));
addEventListener('afterprint', () => print(false));
if (data.reload) setTimeout(() => location.reload(), 1000 * data.reload);
