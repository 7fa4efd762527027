// What programs in bench/ measured: scenes that move, lightmaps that are baked; then all of the page is drawn. After
// report_tables.js, in the same function.
// Rows of cells below a head of [text, class].
function fillTable(name, heads, rows) {
  const head = element('tr');
  head.append(...heads.map(([text, kind]) => element('th', text, kind)));
  $(name).querySelector('thead').append(head);
  $(name).querySelector('tbody').append(...rows.map(cells => {
    const line = element('tr');
    line.append(...cells.map((cell, i) => element('td', cell, heads[i][1])));
    return line;
  }));
}

// Methods on scenes that move; none where the chart was made without.
function makeSequences() {
  if (!data.sequences) return;
  $('sequences').hidden = false;
  $('sequences-measured').textContent = data.sequences.measured;
  fillTable('sequences-table', [['scene', 'text'], ['method', 'text'], ['error'], ['flicker'], ['time a frame']],
            data.sequences.points.map(point => [
              point.scene, point.method, percent(point.error),
              point.flicker < point.resolution ? `< ${percent(point.resolution)}` : percent(point.flicker),
              seconds(point.seconds)]));
}

// A method of a bench: its index among those of the bench says how it is drawn.
const bakeMethods = [...new Set((data.bakes?.points ?? []).map(point => point.method))];
const bakeLook = method => bakeMethods.indexOf(method) % SHAPES.length;

function bakeDatasets(points) {
  return bakeMethods.map(method => {
    const own = points.filter(point => point.method === method && point.error > 0);
    const look = bakeLook(method), paint = color('--method-' + look);
    return {
      label: method, points: own, data: own.map(point => ({x: point.seconds, y: 100 * point.error})),
      borderColor: paint, borderWidth: 1.5, showLine: true, pointBorderColor: paint, pointRadius: 5, pointHitRadius: 6,
      pointStyle: SHAPES[look].style, pointRotation: SHAPES[look].rotation || 0,
      pointBackgroundColor: own.map(point => point.judged ? paint : color('--panel')),
    };
  }).filter(set => set.points.length > 0);
}

function bakeScales(points) {
  return {x: {...axis('CPU time (s)', ''), ...range(points.map(point => point.seconds))},
          y: {...axis('rel_rmse over texels (%)', ''), ...range(points.filter(point => point.error > 0).map(point => 100 * point.error))}};
}

const bakeCharts = [];  // {chart, points}, one a scene

function makeBakePanel(scene) {
  const points = data.bakes.points.filter(point => point.scene === scene);
  const box = element('div', undefined, 'panel'), plot = element('div', undefined, 'plot'), canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `${scene}: error of baked texels against time; all figures are in the table below`);
  plot.append(canvas);
  box.append(element('h3', scene), plot);
  $('bakes-panels').append(box);
  const chart = new Chart(canvas, {
    type: 'scatter',
    data: {datasets: bakeDatasets(points)},
    options: {
      animation: false, responsive: true, maintainAspectRatio: false,
      interaction: {mode: 'nearest', intersect: true},
      plugins: {
        legend: {labels: {color: color('--text'), usePointStyle: true}},
        tooltip: {displayColors: false, callbacks: {
          title: items => items.length ? items[0].dataset.label : '',
          label: item => {
            const point = item.dataset.points[item.dataIndex];
            return [point.setting, `${seconds(point.seconds)}, rel_rmse ${percent(point.error)}`];
          },
        }},
      },
      scales: bakeScales(points),
    },
  });
  bakeCharts.push({chart, points});
}

function drawBakes() {
  for (const {chart, points} of bakeCharts) {
    chart.data.datasets = bakeDatasets(points);
    chart.options.scales = bakeScales(points);
    chart.options.plugins.legend.labels.color = color('--text');
    chart.update();
  }
}

// Lightmaps baked by each method; none where the chart was made without.
function makeBakes() {
  if (!data.bakes) return;
  $('bakes').hidden = false;
  $('bakes-measured').textContent = data.bakes.measured;
  [...new Set(data.bakes.points.map(point => point.scene))].forEach(makeBakePanel);
  fillTable('bakes-table', [['scene', 'text'], ['method', 'text'], ['setting', 'text'], ['hemispheres'], ['error'], ['time']],
            data.bakes.points.map(point => [
              point.scene, point.method, point.setting, point.share > 0 ? percent(point.share) : '–',
              percent(point.error) + (point.judged ? '' : ' (not judged)'), seconds(point.seconds)]));
}

function draw() {
  $('error-meaning').textContent = MEANINGS[state.error];
  drawPanels();
  drawInspector();
  drawEqual();
  drawStages();
  drawTable();
  drawBakes();
}

Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
Chart.defaults.font.size = 12;
document.body.classList.toggle('still', still);
writeCaption();
writeLegend();
data.scenes.forEach(makePanel);
makeTable();
makeSequences();
makeBakes();
state.right = bestPoint(data.scenes[0]);
draw();
moveDivider();

for (const radio of document.querySelectorAll('input[name=error]')) {
  radio.addEventListener('change', () => { state.error = radio.value; draw(); });
}
for (const name of ['left', 'right']) {
  $(name).addEventListener('change', () => { state[name] = +$(name).value; draw(); });
}
$('swap').addEventListener('click', () => select(state.scene, state.right, state.left));
$('split').addEventListener('input', moveDivider);
$('level').addEventListener('input', drawEqual);
// Canvases do not follow the style sheet by themselves.
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
