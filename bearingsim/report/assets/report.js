// Charts with their controls and legends, and the table of a page of results. ECharts draws.
const data = JSON.parse(document.getElementById('data').textContent);
const root = document.documentElement;
const SYMBOLS = ['circle', 'rect', 'triangle', 'diamond', 'pin', 'arrow', 'roundRect'];
const FONT = { fontSize: 12, fontFamily: 'system-ui, sans-serif' };
const DONE = 0;
const FAILED = 1;
const drawings = []; // functions that draw a chart anew, at a width

const finite = (value) => value !== null && value !== undefined;
const digits = (value, count = 4) => String(Number(value.toPrecision(count)));
/** Return a colour of the style sheet, or the CSS colour itself. */
const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim() || name;
const shade = (share) => (finite(share) ? `hsl(${270 - 150 * share}, 50%, 50%)` : colour('faint'));

/** Return a custom series of the shapes that `draw(place, point, area)` makes of points [x, ...]. */
const shapes = (name, points, draw, z) => ({
  type: 'custom', name, data: points, silent: true, clip: true, z, tooltip: { show: false },
  encode: { x: 0, y: points[0]?.length > 2 ? [1, 2] : [] },
  renderItem: (params, api) =>
    draw((x, y) => api.coord([x, y]), points[params.dataIndex], params.coordSys),
});

/** Draw vertical bars [x, low, high]. */
const bars = (name, points, stroke, lineWidth, opacity, z) =>
  shapes(name, points.filter((p) => finite(p[1])), (place, [x, low, high]) => {
    const [[x1, y1], [x2, y2]] = [place(x, low), place(x, high)];
    return { type: 'line', shape: { x1, y1, x2, y2 }, style: { stroke, lineWidth, opacity } };
  }, z);

/** Draw a band [x, low, high], as bars if points lack one. */
function band(points, fill) {
  if (points.length < 2 || !points.every((p) => finite(p[1])))
    return bars('band', points, fill, 5, 0.35, 0);
  return shapes('band', points, (place, point) => {
    if (point !== points[0]) return null;
    const upper = points.map(([x, , high]) => place(x, high));
    const lower = points.map(([x, low]) => place(x, low)).reverse();
    return {
      type: 'polygon', shape: { points: [...upper, ...lower] }, style: { fill, opacity: 0.18 },
    };
  }, 0);
}

/** Write a text at places on the x axis: x, text, and the part of the height above it. */
const texts = (points, fill, high) =>
  shapes('text', points, (place, [x, text], area) => ({
    type: 'text', x: place(x, 1)[0], y: area.y + (high ? 0 : area.height),
    style: { ...FONT, text, fill, align: 'center', verticalAlign: high ? 'top' : 'bottom' },
  }), 4);

/** Mark the spectral lines [frequency, name]; names that would overlap are left out. */
function marks(points, area) {
  const named = points.filter((p) => p[1]);
  const step = Math.ceil(named.length / Math.max(1, area / 70));
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
  const stroke = colour(curve.colour);
  const known = list.filter((i) => finite(at('y', i)));
  const bounds = known.filter((i) => finite(at('error', i)))
    .map((i) => [x[i], at('y', i) - at('error', i), at('y', i) + at('error', i)]);
  const lost = list.filter((i) => chart.points.state && chart.points.state[i] !== DONE)
    .map((i) => [x[i], chart.points.state[i] === FAILED ? '×' : '|']);
  const still = { silent: true, tooltip: { show: false } };
  return [
    band(rows(list, 'low', 'high'), stroke),
    bars('error', bounds, stroke, 1.5, 1, 3),
    texts(lost, colour('lost')),
    { type: 'line', name: 'healthy', data: rows(list, 'healthy').filter((p) => finite(p[1])),
      ...still, symbol: 'none', z: 1,
      lineStyle: { color: healthy ? colour('faint') : stroke, width: 1, type: [4, 3] } },
    { type: 'scatter', name: 'chaotic', data: rows(known.filter((i) => at('chaotic', i)), 'y'),
      ...still, symbolSize: 16, z: 1,
      itemStyle: { color: 'transparent', borderColor: colour('faint'), borderWidth: 1.5 } },
    { type: ['points', 'design'].includes(chart.kind) ? 'scatter' : 'line', name: curve.name,
      data: list.map((i) => ({ value: [x[i], at('y', i) ?? null], point: i,
        ...(shares && { itemStyle: { color: shade(shares[i]) } }) })),
      color: stroke, z: 2, emphasis: { disabled: true }, showAllSymbol: true, symbolSize: 7,
      symbol: chart.kind === 'signal' ? 'none' : SYMBOLS[curve.symbol % 7],
      lineStyle: { color: stroke, width: chart.kind === 'signal' ? 1 : 2,
        type: curve.dash.length ? curve.dash : 'solid' } },
  ];
}

/** Return the series of a panel. */
function seriesOf(chart, panel, { x, lists, hidden, shares, trend, width }) {
  const level = (list) => `${list.map((i) => [x[i], panel.columns.healthy?.[i]])}`;
  const shared = new Set(lists.filter((list) => list.length).map(level)).size < 2;
  const drawn = chart.curves.map((curve, k) => [curve, lists[k]])
    .filter(([curve, list]) => list.length && !hidden.has(curve.name));
  const groups = panel.trends[trend] ?? [];
  const line = { type: 'line', name: 'median', symbol: 'none', silent: true, z: 3,
    data: groups.map((group) => [group[0], group[2]]), tooltip: { show: false },
    lineStyle: { color: colour('ink'), width: 2 } };
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
    const range = finite(low) ? ` (${digits(low)} to ${digits(high)})` : '';
    const value = finite(at('y', i)) ? digits(at('y', i)) : 'no value';
    const name = item.seriesName && `${item.seriesName}: `;
    return `${name}${value}${bound} ${panel.unit}${range}${at('chaotic', i) ? ', chaotic' : ''}`;
  });
  const place = items[0]?.value?.[0];
  const text = axis.words.length ? axis.words[place] : finite(place) && digits(place, 5);
  return lines.length ? [`${axis.label}: ${text}`, ...lines].join('\n') : '';
}

/** Return the options of ECharts for a panel. */
function optionOf(chart, panel, axis, view) {
  const text = { ...FONT, color: colour('ink') };
  const lines = { lineStyle: { color: colour('faint') } };
  const values = view.lists.flat().map((i) => panel.columns.y[i]).filter(finite);
  const style = {
    axisLabel: { ...text, hideOverlap: true }, axisLine: lines, axisTick: lines,
    splitLine: { lineStyle: { color: colour('line') } }, nameTextStyle: text,
  };
  const turned = axis.words.join('').length * 7 > 0.6 * view.width ? 30 : 0;
  const words = { type: 'category', data: axis.words,
    axisLabel: { ...style.axisLabel, interval: 0, rotate: turned } };
  const numbers = (log) => ({ type: log ? 'log' : 'value' });
  const ends = panel.axis.phase ? { min: -180, max: 180, interval: 90 }
    : { ...numbers(panel.axis.log), scale: values.some((value) => value < 0) };
  return {
    animation: false, textStyle: text,
    aria: { enabled: true, label: { description: `${panel.axis.label}; x: ${axis.label}` } },
    grid: { left: 4, right: 22, top: 10, bottom: 24, containLabel: true },
    xAxis: { ...style, scale: true, ...(axis.words.length ? words : numbers(axis.log)),
      name: axis.label, nameLocation: 'middle', nameGap: turned ? 60 : 26 },
    yAxis: { ...style, ...ends },
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
  const isDesign = chart.kind === 'design';
  let setting = chart.controls.map((control) => control.start);
  const draw = (width) => {
    const wanted = chart.combinations.findIndex((key) => `${key}` === `${setting}`);
    const all = [...chart.x[0].keys()];
    const lists = isDesign ? [all] : chart.curves.map((_, k) => all.filter((i) =>
      chart.points.curve[i] === k && chart.points.combination[i] === wanted));
    const trend = isDesign ? setting[0] : 0;
    const shares = isDesign && chart.shades[setting[1] - 1];
    plots.forEach((plot, k) => {
      plot.resize({ width });
      const view = { x: chart.x[trend], lists, hidden, shares, trend, width: plot.getWidth() };
      plot.setOption(optionOf(chart, chart.panels[k], chart.axes[trend], view), { notMerge: true });
    });
    controls.forEach((label, k) => {
      const input = label.querySelector('input, select');
      const text = chart.controls[k].options[setting[k]];
      input.value = setting[k];
      if (input.type === 'range') input.setAttribute('aria-valuetext', text);
      label.querySelector('output').textContent = text;
    });
  };
  controls.forEach((label, k) => {
    label.addEventListener('input', (event) => {
      setting = nearest(chart, setting, k, Number(event.target.value));
      draw();
    });
  });
  section.querySelectorAll('.legend input').forEach((input, k) => {
    input.addEventListener('change', () => {
      hidden[input.checked ? 'delete' : 'add'](chart.curves[k].name);
      draw();
    });
  });
  plots.forEach((plot, k) => {
    const zoom = (first) => plot.dispatchAction({ type: 'dataZoom', start: first, end: 100 - first });
    boxes[k].addEventListener('dblclick', () => zoom(0));
    boxes[k].addEventListener('keydown', ({ key }) => {
      if (key === '+' || key === '-') zoom(key === '+' ? 25 : 0);
    });
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
  heads.forEach((head, i) => {
    head.addEventListener('click', () => {
      const sign = head.ariaSort === 'ascending' ? -1 : 1;
      const order = (a, b) => Number.parseFloat(a) - Number.parseFloat(b) || a.localeCompare(b);
      for (const other of heads) other.ariaSort = 'none';
      head.ariaSort = sign > 0 ? 'ascending' : 'descending';
      body.append(...rows.sort((a, b) => sign * order(cell(a, i), cell(b, i))));
    });
  });
  document.getElementById('filter').addEventListener('input', (event) => {
    const words = event.target.value.toLowerCase().split(' ');
    for (const row of rows) {
      row.hidden = !words.every((word) => row.textContent.toLowerCase().includes(word));
    }
  });
  document.getElementById('copy').addEventListener('click', async () => {
    const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const line = (cells) => cells.map((c) => quoted(c.textContent.trim())).join(',');
    const lines = [heads, ...rows.filter((row) => !row.hidden).map((row) => [...row.cells])];
    await navigator.clipboard.writeText(lines.map(line).join('\n'));
    document.getElementById('copied').textContent = `${lines.length - 1} rows copied`;
  });
}

for (const section of document.querySelectorAll('[data-chart]')) start(section);
table();
const redraw = (width) => { for (const draw of drawings) draw(width); };
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => redraw());
addEventListener('resize', () => redraw());
const print = (on) => { root.classList.toggle('print', on); redraw(on ? 660 : 'auto'); };
addEventListener('beforeprint', () => print(true));
addEventListener('afterprint', () => print(false));
