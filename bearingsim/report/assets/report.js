// Charts with their controls and legends, and the table of a page of results. ECharts draws.
const data = JSON.parse(document.getElementById('data').textContent);
const root = document.documentElement;
const DASHES = ['solid', [6, 3], [2, 2], [6, 2, 1, 2], [3, 1, 1, 1, 1, 1]];
const SYMBOLS = ['circle', 'rect', 'triangle', 'diamond', 'pin', 'arrow', 'roundRect'];
const FONT = { fontSize: 12, fontFamily: 'system-ui, sans-serif' };
const shown = []; // functions that draw a chart anew

const digits = (value, count = 4) => String(Number(value.toPrecision(count)));
const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
const isDark = () =>
  !root.classList.contains('print') && matchMedia('(prefers-color-scheme: dark)').matches;
const shade = (share) =>
  `hsl(${270 - 190 * share}, 55%, ${isDark() ? 60 + 15 * share : 25 + 20 * share}%)`;
const finite = (value) => value !== null && value !== undefined;

/** Return colour and dash of a curve: from a list, or a shade if the curves are ordered. */
function look(chart, curve) {
  const count = Math.max(...chart.curves.map((other) => other.colour)) + 1;
  const dashed = chart.curves.some((other) => other.dash > 0);
  if (chart.ordered) return [shade(curve.colour / (count - 1)), DASHES[curve.dash % 5]];
  return [colour(`curve${curve.colour % 7}`), DASHES[(dashed ? curve.dash : curve.colour) % 5]];
}

/** Return a custom series of the shapes that `draw(place, point)` makes of points [x, ...]. */
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
function band(name, points, fill) {
  if (points.length < 2 || !points.every((p) => finite(p[1])))
    return bars(name, points, fill, 5, 0.35, 0);
  return shapes(name, points, (place, point) => {
    if (point !== points[0]) return null;
    const upper = points.map(([x, , high]) => place(x, high));
    const lower = points.map(([x, low]) => place(x, low)).reverse();
    return {
      type: 'polygon', shape: { points: [...upper, ...lower] }, style: { fill, opacity: 0.18 },
    };
  }, 0);
}

/** Mark the place on the x axis of jobs without a value. */
const lost = (chart, points) =>
  shapes('lost', points, (place, [x, i], area) => ({
    type: 'text', x: place(x, 1)[0], y: area.y + area.height,
    style: {
      ...FONT, text: chart.points.status[i] === 'failed' ? '×' : '|', fontSize: 16,
      fill: colour('lost'), align: 'center', verticalAlign: 'bottom',
    },
  }), 4);

/** Return the series of a panel: of each curve its band, healthy level, error bounds and marks. */
function seriesOf(chart, panel, x, lists, hidden) {
  const at = (key, i) => panel.columns[key]?.[i];
  const rows = (list, ...keys) => list.map((i) => [x[i], ...keys.map((key) => at(key, i))]);
  const levels = new Set(lists.filter((l) => l.length).map((l) => `${rows(l, 'healthy')}`));
  return lists.flatMap((list, k) => {
    const curve = chart.curves[k];
    if (!list.length || hidden.has(curve.name)) return [];
    const [stroke, type] = look(chart, curve);
    const known = list.filter((i) => finite(at('y', i)));
    const bounds = known.filter((i) => finite(at('error', i)))
      .map((i) => [x[i], at('y', i) - at('error', i), at('y', i) + at('error', i)]);
    const line = { type: 'line', symbol: 'none', silent: true, z: 1, tooltip: { show: false } };
    const healthyColour = levels.size > 1 ? stroke : colour('faint');
    return [
      band('band', rows(list, 'low', 'high'), stroke),
      bars('error', bounds, stroke, 1.5, 1, 3),
      lost(chart, list.filter((i) => chart.points.status?.[i] === 'failed'
        || chart.points.status?.[i] === 'missing').map((i) => [x[i], i])),
      { ...line, name: 'healthy', data: rows(list, 'healthy').filter((p) => finite(p[1])),
        lineStyle: { color: healthyColour, width: 1, type: [4, 3] } },
      { type: 'scatter', name: 'chaotic', data: rows(known.filter((i) => at('chaotic', i)), 'y'),
        symbolSize: 16, silent: true, z: 1, tooltip: { show: false },
        itemStyle: { color: 'transparent', borderColor: colour('faint'), borderWidth: 1.5 } },
      { type: chart.lines ? 'line' : 'scatter', name: curve.name, color: stroke, z: 2,
        data: list.map((i) => ({ value: [x[i], at('y', i) ?? null], point: i })),
        symbol: chart.dense ? 'none' : SYMBOLS[curve.colour % 7], symbolSize: 7,
        showAllSymbol: true, emphasis: { disabled: true },
        lineStyle: { color: stroke, width: chart.dense ? 1 : 2, type } },
    ];
  });
}

/** Return the text over points at one place on the x axis. */
function tooltip(panel, axis, items) {
  const at = (key, i) => panel.columns[key]?.[i];
  const texts = items.filter((item) => finite(item.data.point)).map((item) => {
    const i = item.data.point;
    const bound = finite(at('error', i)) ? ` ± ${digits(at('error', i), 2)}` : '';
    const [low, high] = [at('low', i), at('high', i)];
    const range = finite(low) ? ` (${digits(low)} to ${digits(high)})` : '';
    const value = finite(at('y', i)) ? digits(at('y', i)) : 'no value';
    const chaotic = at('chaotic', i) ? ', chaotic' : '';
    const name = item.seriesName && `${item.seriesName}: `;
    return `${name}${value}${bound} ${panel.unit.split(',')[0]}${range}${chaotic}`;
  });
  const place = items[0]?.value?.[0];
  const text = axis.words.length ? axis.words[place] : finite(place) && digits(place, 5);
  return texts.length ? [`${axis.label}: ${text}`, ...texts].join('\n') : '';
}

/** Return the options of ECharts for a panel. */
function optionOf(chart, panel, axis, x, lists, hidden, narrow) {
  const text = { ...FONT, color: colour('ink') };
  const lines = { lineStyle: { color: colour('faint') } };
  const values = lists.flat().map((i) => panel.columns.y[i]).filter(finite);
  const positive = values.every((value) => value >= 0);
  const style = {
    axisLabel: { ...text, hideOverlap: true }, axisLine: lines, axisTick: lines,
    splitLine: { lineStyle: { color: colour('line') } }, nameTextStyle: text,
  };
  const words = axis.words.length > 0;
  const turned = axis.words.join('').length > (narrow ? 24 : 60) ? 30 : 0;
  const wordLabels = { ...style.axisLabel, interval: 0, rotate: turned };
  const kind = (log) => (log ? { type: 'log' } : { type: 'value' });
  const ends = panel.axis.phase ? { min: -180, max: 180, interval: 90 }
    : { ...kind(panel.axis.log), scale: !positive };
  return {
    animation: false, textStyle: text,
    aria: { enabled: true, label: { description: `${panel.axis.label}; x: ${axis.label}` } },
    grid: { left: 4, right: 22, top: 10, bottom: 24, containLabel: true },
    xAxis: {
      ...style, ...(words ? { type: 'category', data: axis.words } : kind(axis.log)), scale: true,
      axisLabel: words ? wordLabels : style.axisLabel, name: axis.label, nameLocation: 'middle',
      nameGap: turned ? 60 : 26,
    },
    yAxis: { ...style, ...ends },
    dataZoom: [{
      type: 'inside', filterMode: 'none', zoomOnMouseWheel: 'ctrl', moveOnMouseWheel: false,
      moveOnMouseMove: 'shift', preventDefaultMouseMove: false,
    }],
    tooltip: {
      trigger: chart.lines ? 'axis' : 'item', renderMode: 'richText', confine: true,
      textStyle: text, backgroundColor: colour('paper'), borderColor: colour('faint'),
      formatter: (items) => tooltip(panel, axis, [items].flat()),
    },
    series: seriesOf(chart, panel, x, lists, hidden),
  };
}

/** Write the legend: a switch for each curve. */
function legend(box, chart, lists, hidden, draw) {
  const curves = chart.curves.filter((curve, k) => curve.name && lists[k].length);
  box.replaceChildren(...(curves.length > 1 ? curves : []).map((curve) => {
    const [label, input] = [document.createElement('label'), document.createElement('input')];
    const [svg, line] = ['svg', 'path'].map((tag) =>
      document.createElementNS('http://www.w3.org/2000/svg', tag));
    const [stroke, dash] = look(chart, curve);
    line.setAttribute('d', 'M0 6H28');
    line.setAttribute('stroke', stroke);
    line.setAttribute('stroke-width', 3);
    line.setAttribute('stroke-dasharray', [dash].flat().filter(Number).join(' '));
    svg.append(line);
    input.type = 'checkbox';
    input.checked = !hidden.has(curve.name);
    input.addEventListener('change', () => {
      hidden[input.checked ? 'delete' : 'add'](curve.name);
      draw();
    });
    label.append(input, svg, curve.name);
    return label;
  }));
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
  const draw = (width) => {
    const wanted = chart.combinations.findIndex((key) => `${key}` === `${setting}`);
    const lists = chart.curves.map((_, k) => [...chart.points.curve.keys()].filter((i) =>
      chart.points.curve[i] === k && chart.points.combination[i] === wanted));
    plots.forEach((plot, k) => {
      plot.resize({ width });
      plot.setOption(optionOf(chart, chart.panels[k], chart.x, chart.points.x, lists, hidden,
        plot.getWidth() < 500), { notMerge: true });
    });
    legend(section.querySelector('.legend'), chart, lists, hidden, draw);
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
  plots.forEach((plot, k) => {
    const zoom = (start) => plot.dispatchAction({ type: 'dataZoom', start, end: 100 - start });
    boxes[k].addEventListener('dblclick', () => zoom(0));
    boxes[k].addEventListener('keydown', ({ key }) => {
      if (key in { '+': 0, '-': 0 }) zoom(key === '+' ? 25 : 0);
    });
  });
  shown.push(draw);
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
const redraw = (width) => { for (const draw of shown) draw(width); };
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => redraw());
addEventListener('resize', () => redraw());
const print = (on) => { root.classList.toggle('print', on); redraw(on ? 660 : 'auto'); };
addEventListener('beforeprint', () => print(true));
addEventListener('afterprint', () => print(false));
