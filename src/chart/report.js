// The page of `sheen chart`: charts of all scenes, and two points of one of them to look at.
// Figures and images come from the JSON in #data; report.cpp writes it. report.html puts this, report_tables.js and
// report_benches.js into one function.
const data = JSON.parse(document.getElementById('data').textContent);
const $ = id => document.getElementById(id);
const color = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const MEANINGS = {
  rel_rmse: 'root of the mean squared difference over the mean, the reference’s own noise taken off',
  median: 'of the pixels’ relative errors, the reference’s noise included',
  tile_max: 'rel_rmse of the worst tile of 16 × 16 pixels, noise taken off',
};
// Of methods, in the charts and as the legend draws them. Closed, so that they can be hollow.
const SHAPES = [
  {style: 'circle', path: 'M-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0'},
  {style: 'rect', path: 'M-4.5 -4.5h9v9h-9z'},
  {style: 'triangle', path: 'M0 -5.5L5.5 4.5H-5.5Z'},
  {style: 'rectRot', path: 'M0 -5.5L5.5 0L0 5.5L-5.5 0Z'},
  {style: 'triangle', rotation: 180, path: 'M0 5.5L5.5 -4.5H-5.5Z'},
  {style: 'triangle', rotation: 90, path: 'M5.5 0L-4.5 5.5V-5.5Z'},
  {style: 'triangle', rotation: 270, path: 'M-5.5 0L4.5 5.5V-5.5Z'},
  {style: 'rectRounded', path: 'M-2 -4.5h4q2.5 0 2.5 2.5v4q0 2.5 -2.5 2.5h-4q-2.5 0 -2.5 -2.5v-4q0 -2.5 2.5 -2.5z'},
];
const REFERENCE = -1;  // in place of a point's index
const still = location.hash === '#charts';  // the charts alone, to take a picture of

const methodIndex = new Map(data.methods.map((method, i) => [method.name, i]));
const methodVariable = name => '--method-' + methodIndex.get(name) % SHAPES.length;
const methodColor = name => color(methodVariable(name));
const methodShape = name => SHAPES[methodIndex.get(name) % SHAPES.length];
const methodLabel = name => data.methods[methodIndex.get(name)].label;

// A browser that loads the page again may keep what was chosen.
const state = {error: document.querySelector('input[name=error]:checked').value, scene: 0,
               left: REFERENCE, right: 0};
const panels = [];  // {chart, element} [scene]
let stagesChart = null;

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

// Three significant digits, never in exponential form.
function digits(value) {
  if (value === null || !isFinite(value)) return '–';
  if (value === 0) return '0';
  const places = 2 - Math.floor(Math.log10(Math.abs(value)));
  return value.toFixed(Math.min(Math.max(places, 0), 6));
}
const percent = value => value === null ? '–' : digits(100 * value) + '%';
const seconds = value => value === null ? '–' : digits(value) + ' s';
const title = point => `${methodLabel(point.method)}, ${point.setting}`;
const drawable = (point, error) => point.errors[error] !== null && point.errors[error] > 0;

// The caption says what was measured, where and with what.
function writeCaption() {
  const renderers = new Set(), builds = new Set();
  for (const scene of data.scenes) {
    for (const point of scene.points) {
      if (point.gl_renderer) renderers.add(point.gl_renderer);
      builds.add(`${point.version} (build ${point.build.slice(0, 8)})`);
    }
  }
  const most = Math.max(...data.scenes.flatMap(scene => scene.points.map(point => point.runs.length)));
  const runs = most > 1 ? `the median of up to ${most} runs` : 'one run';
  const noises = data.scenes.map(scene => `${scene.name} ${percent(scene.reference.noise_rel_rmse)}`);
  const bounces = data.bounces === 'all' ? 'all bounces' : data.bounces === 1 ? 'one bounce' : `${data.bounces} bounces`;
  $('caption').textContent =
      `Measured by sheen ${[...builds].join(', ')} at ${data.size[0]} × ${data.size[1]} pixels on ` +
      `${data.cpu}, ${data.threads} thread${data.threads === 1 ? '' : 's'}` +
      (renderers.size ? `, ${[...renderers].join(', ')}` : '') + '. ' +
      `Time is the wall clock of the whole command, from its start to the image on disk, ${runs} ` +
      `with a warm shader cache. Errors are of the indirect light of ${bounces} against ` +
      `path-traced references of ${data.reference_spp} paths a pixel, independent of the charted ` +
      `path tracer. Their own noise: ${noises.join(', ')}.`;
}

// Marks of the legend are drawn as Chart.js draws the points.
function writeLegend() {
  const NS = 'http://www.w3.org/2000/svg';
  const mark = (shape, paint) => {
    const svg = document.createElementNS(NS, 'svg');
    svg.setAttribute('viewBox', '-11 -7 22 14');
    const path = document.createElementNS(NS, 'path');
    path.setAttribute('d', shape);
    path.setAttribute('style', paint);
    svg.append(path);
    return svg;
  };
  const list = $('legend');
  list.replaceChildren();
  const add = (svg, text) => {
    const item = element('li');
    item.append(svg, text);
    list.append(item);
  };
  for (const method of data.methods) {
    const paint = `var(${methodVariable(method.name)})`;
    add(mark(methodShape(method.name).path, `fill:${paint};stroke:${paint};stroke-width:1.5`), method.label);
  }
  add(mark('M-11 -5H0V5H11', 'fill:none;stroke:var(--front);stroke-width:3'), 'Pareto front');
  add(mark(SHAPES[0].path, 'fill:none;stroke:var(--faint);stroke-width:1.5'),
      'hollow: error is mostly the reference’s noise; not on the front');
  add(mark('M-11 0H11', 'fill:none;stroke:var(--faint);stroke-width:1.5;stroke-dasharray:2 3'),
      'the reference’s own noise (rel_rmse)');
}

// 1, 2 and 5 times powers of ten.
function logTick(value, unit) {
  const mantissa = value / 10 ** Math.floor(Math.log10(value) + 1e-9);
  return [1, 2, 5].some(step => Math.abs(mantissa - step) < 1e-6) ? +value.toPrecision(3) + unit : '';
}

function axis(title, unit) {
  return {
    type: 'logarithmic',
    title: {display: true, text: title, color: color('--text')},
    ticks: {color: color('--faint'), callback: value => logTick(value, unit), maxRotation: 0,
            autoSkip: false},
    grid: {color: context => logTick(context.tick.value, ' ') ? color('--grid') : 'transparent',
           borderColor: color('--line'), tickLength: 4},
  };
}

// A little room around the values, so that no point lies on the frame.
function range(values) {
  return values.length ? {min: Math.min(...values) / 1.25, max: Math.max(...values) * 1.25}
                       : {min: 0.1, max: 10};
}

function datasets(scene, sceneIndex) {
  const sets = [];
  for (const method of data.methods) {
    const indices = scene.points.map((_, i) => i).filter(
        i => scene.points[i].method === method.name && drawable(scene.points[i], state.error));
    const paint = methodColor(method.name);
    const chosen = i => !still && sceneIndex === state.scene && (i === state.left || i === state.right);
    sets.push({
      label: method.label, order: 1, indices,
      data: indices.map(i => ({x: scene.points[i].seconds, y: 100 * scene.points[i].errors[state.error]})),
      borderColor: paint, borderWidth: 1.5, showLine: true,
      pointStyle: methodShape(method.name).style,
      pointRotation: methodShape(method.name).rotation || 0,
      pointBackgroundColor: indices.map(
          i => scene.points[i].errors.judged ? paint : color('--panel')),
      pointBorderColor: paint,
      pointBorderWidth: indices.map(i => chosen(i) ? 3 : 1.5),
      pointRadius: indices.map(i => chosen(i) ? 8 : 5),
      pointHoverRadius: 9, pointHitRadius: 6,
    });
  }
  sets.push({
    label: 'Pareto front', order: 2, indices: [],
    data: scene.pareto[state.error].map(
        i => ({x: scene.points[i].seconds, y: 100 * scene.points[i].errors[state.error]})),
    borderColor: color('--front'), borderWidth: 5, stepped: 'before', pointRadius: 0,
    pointHitRadius: 0, showLine: true,
  });
  return sets;
}

function scales(scene) {
  const points = scene.points.filter(point => drawable(point, state.error));
  const errors = points.map(point => 100 * point.errors[state.error]);
  const noise = 100 * scene.reference.noise_rel_rmse;
  if (state.error === 'rel_rmse' && errors.length && noise > 0) errors.push(noise);
  return {x: {...axis('wall time (s)', ''), ...range(points.map(point => point.seconds))},
          y: {...axis(`${state.error} (%)`, ''), ...range(errors)}};
}

// A dashed line at the reference's own noise, where it is comparable to what is drawn.
const noiseLine = {
  id: 'noise',
  beforeDatasetsDraw(chart) {
    const noise = 100 * chart.options.scene.reference.noise_rel_rmse;
    const {left, right, top, bottom} = chart.chartArea;
    const y = chart.scales.y.getPixelForValue(noise);
    if (state.error !== 'rel_rmse' || !(noise > 0) || y < top || y > bottom) return;
    const context = chart.ctx;
    context.save();
    context.strokeStyle = color('--faint');
    context.setLineDash([2, 4]);
    context.beginPath();
    context.moveTo(left, y);
    context.lineTo(right, y);
    context.stroke();
    context.restore();
  },
};

function tooltip(scene) {
  const pointOf = item => scene.points[item.dataset.indices[item.dataIndex]];
  return {
    displayColors: false,
    callbacks: {
      title: items => items.length ? title(pointOf(items[0])) : '',
      label: item => {
        const point = pointOf(item), e = point.errors;
        const lines = [
          `${seconds(point.seconds)} (${point.runs.length} run${point.runs.length === 1 ? '' : 's'})`,
          `rel_rmse ${percent(e.rel_rmse)}, median ${percent(e.median)}, tile_max ${percent(e.tile_max)}`];
        if (point.records) lines.push(`${point.records} records`);
        if (!e.judged) lines.push(`not judged: ${(100 * e.noise_share).toFixed(0)}% of the difference is the reference’s noise`);
        return lines;
      },
    },
  };
}

function makePanel(scene, sceneIndex) {
  const box = element('div', undefined, 'panel');
  const heading = element('h3');
  const choose = element('button', scene.name);
  choose.type = 'button';
  choose.title = 'Look at this scene';
  choose.addEventListener('click', () => select(sceneIndex, REFERENCE, bestPoint(scene)));
  heading.append(choose, ' ', element('span', `camera ${scene.camera}`));
  const plot = element('div', undefined, 'plot');
  const canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `${scene.name}: error against time; all figures are in the table below`);
  plot.append(canvas);
  box.append(heading, plot, element('p', '', 'left-out'));
  $('panels').append(box);
  const chart = new Chart(canvas, {
    type: 'scatter',
    data: {datasets: datasets(scene, sceneIndex)},
    plugins: [noiseLine],
    options: {
      scene, animation: false, responsive: true, maintainAspectRatio: false,
      interaction: {mode: 'nearest', intersect: true},
      plugins: {legend: {display: false}, tooltip: tooltip(scene)},
      scales: scales(scene),
      onHover: (event, hit) => { canvas.style.cursor = hit.length ? 'pointer' : ''; },
      onClick: (event, hit) => {
        if (!hit.length) return;
        const index = chart.data.datasets[hit[0].datasetIndex].indices[hit[0].index];
        const here = sceneIndex === state.scene;
        if (event.native.shiftKey) select(sceneIndex, index, here ? state.right : bestPoint(scene));
        else select(sceneIndex, here ? state.left : REFERENCE, index);
      },
    },
  });
  panels.push({chart, box});
}

function drawPanels() {
  panels.forEach(({chart, box}, i) => {
    const scene = data.scenes[i];
    chart.data.datasets = datasets(scene, i);
    chart.options.scales = scales(scene);
    chart.update();
    box.classList.toggle('chosen', i === state.scene);
    const out = scene.points.filter(point => !drawable(point, state.error)).length;
    box.querySelector('.left-out').textContent =
        out ? `${out} point${out === 1 ? '' : 's'} not drawn: no error beyond the reference’s noise, or none defined` : '';
  });
}

// What to show first: the best point that the reference can judge.
function bestPoint(scene) {
  const front = scene.pareto.rel_rmse;
  return front.length ? front[front.length - 1] : 0;
}

function select(scene, left, right) {
  Object.assign(state, {scene, left, right});
  draw();
}

function side(name, index) {
  const scene = data.scenes[state.scene];
  const point = index === REFERENCE ? null : scene.points[index];
  const label = point ? title(point) : `reference, ${data.reference_spp} paths a pixel`;
  const image = $('image-' + name), heat = $('heatmap-' + name);
  image.src = point ? point.image : scene.reference.image;
  image.alt = `${scene.name}, indirect light: ${label}`;
  $('tag-' + name).textContent = label;
  heat.hidden = !point;
  if (point) heat.src = point.heatmap; else heat.removeAttribute('src');
  heat.alt = point ? `Relative error of ${label}` : '';
  const caption = $('figures-' + name);
  caption.replaceChildren(element('strong', label));
  if (!point) {
    caption.append(`What the others are judged by; ${seconds(scene.reference.seconds)}, ` +
                   `its own noise ${percent(scene.reference.noise_rel_rmse)}.`);
    return;
  }
  const list = element('dl');
  const e = point.errors;
  const rows = [['wall time', seconds(point.seconds)], ['rel_rmse', percent(e.rel_rmse)],
                ['bias', percent(e.bias)], ['median', percent(e.median)],
                ['tile_max', percent(e.tile_max)]];
  if (point.cold_seconds !== null) rows.splice(1, 0, ['cold', seconds(point.cold_seconds)]);
  if (point.records) rows.push(['records', point.records]);
  if (!e.judged) rows.push(['not judged', `${(100 * e.noise_share).toFixed(0)}% reference noise`]);
  for (const [name, value] of rows) list.append(element('dt', name), element('dd', value));
  caption.append(list);
}

function drawInspector() {
  const scene = data.scenes[state.scene];
  $('inspector-title').textContent = scene.name;
  for (const name of ['left', 'right']) {
    const options = [new Option(`reference, ${data.reference_spp} paths a pixel`, REFERENCE)];
    scene.points.forEach((point, i) => options.push(new Option(`${title(point)} (${seconds(point.seconds)})`, i)));
    $(name).replaceChildren(...options);
    $(name).value = state[name];
    side(name, state[name]);
  }
}

function moveDivider() {
  const at = $('split').value;
  $('image-left').style.clipPath = `inset(0 ${100 - at}% 0 0)`;
  $('divider').style.left = at + '%';
}
