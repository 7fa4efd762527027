// The page's tables: times to equal errors, stages, all points. After report.js, in the same function.
// The points, of those that the reference can judge, at which a method gets better than by any that
// is as fast.
function bestOf(scene, method) {
  const best = [];
  const judged = scene.points
      .filter(point => point.method === method && point.errors.judged && point.errors[state.error] !== null)
      .map(point => ({seconds: point.seconds, error: point.errors[state.error]}));
  for (const point of judged.sort((a, b) => a.seconds - b.seconds || a.error - b.error)) {
    if (!best.length || point.error < best.at(-1).error) best.push(point);
  }
  return best;
}

// When such points reach an error: on the straight line, in logarithms, between the two around it.
// `bound`: at the latest; the fastest point is better already, or the line would end at no error.
// Null: none is as good.
function timeTo(best, error) {
  const next = best.findIndex(point => point.error <= error);
  if (next < 0) return null;
  const a = best[next - 1], b = best[next];
  if (b.error === error) return {seconds: b.seconds, bound: false};
  if (!a || b.error === 0) return {seconds: b.seconds, bound: true};
  const along = Math.log(error / a.error) / Math.log(b.error / a.error);
  return {seconds: a.seconds * (b.seconds / a.seconds) ** along, bound: false};
}

// What is known where a method does not reach an error: points that cannot be judged may have.
function unreached(scene, method, best) {
  const open = scene.points.some(point => point.method === method && !point.errors.judged);
  if (!best.length) return open ? 'not judged' : '–';
  const least = percent(best.at(-1).error);
  return open ? `not judged below ${least}` : `${least} at best`;
}

function drawEqual() {
  const error = $('level').valueAsNumber / 100;
  const head = element('tr'), body = $('equal-table').querySelector('tbody');
  head.append(element('th', 'method', 'text'), ...data.scenes.map(scene => element('th', scene.name)));
  $('equal-table').querySelector('thead').replaceChildren(head);
  const best = data.scenes.map(scene => data.methods.map(method => bestOf(scene, method.name)));
  const times = best.map(ofScene => ofScene.map(points => error > 0 ? timeTo(points, error) : null));
  body.replaceChildren(...data.methods.map((method, m) => {
    const line = element('tr');
    line.append(methodCell(method.name));
    times.forEach((ofScene, s) => {
      const own = ofScene[m];
      if (!own) {
        line.append(element('td', unreached(data.scenes[s], method.name, best[s][m]), 'unreached'));
        return;
      }
      const cell = element('td', (own.bound ? '< ' : '') + seconds(own.seconds));
      // Of a bound no ratio is known. Whatever has one may be the fastest, and faster than it says:
      // then ratios are at least as great.
      const fastest = Math.min(...ofScene.filter(time => time).map(time => time.seconds));
      const open = ofScene.some(time => time?.bound);
      if (own.seconds > fastest && !own.bound) {
        cell.append(` (${open ? '> ' : ''}${digits(own.seconds / fastest)}×)`);
      }
      line.append(cell);
    });
    return line;
  }));
}

const STAGE_COLORS = {  // a stage keeps its colour; light to dark in the order they run
  load: '#8da0b3', gbuffer: '#7a6fb0', shadow: '#b07aa1', placement: '#e69f00', gather: '#0072b2',
  project: '#56b4e9', splat: '#009e73', compose: '#c9b800', trace: '#d55e00', write: '#7f6a55',
  other: '#9aa4ae'};
const SPARE_COLORS = ['#cc79a7', '#5b8c2a', '#a0522d', '#3f51b5'];

function drawStages() {
  const scene = data.scenes[state.scene];
  $('stages-title').textContent = `Where the time goes: ${scene.name}`;
  const stages = [];
  for (const point of scene.points) {
    for (const stage of Object.keys(point.stages)) if (!stages.includes(stage)) stages.push(stage);
  }
  const order = Object.keys(STAGE_COLORS);
  const rank = stage => order.includes(stage) ? order.indexOf(stage) : order.length - 2.5;
  stages.sort((a, b) => rank(a) - rank(b));
  let spare = 0;
  const total = point => Object.values(point.stages).reduce((sum, s) => sum + s, 0);
  const sets = stages.map(stage => ({
    label: stage,
    data: scene.points.map(point => 100 * (point.stages[stage] || 0) / total(point)),
    seconds: scene.points.map(point => point.stages[stage] || 0),
    backgroundColor: STAGE_COLORS[stage] || SPARE_COLORS[spare++ % SPARE_COLORS.length],
    borderWidth: 0, barPercentage: 0.8, categoryPercentage: 0.95,
  }));
  $('stages-box').style.height = `${90 + 22 * scene.points.length}px`;
  $('stages-canvas').setAttribute('aria-label', `Stage times of ${scene.name}; they are also in chart.csv`);
  if (stagesChart) stagesChart.destroy();
  stagesChart = new Chart($('stages-canvas'), {
    type: 'bar',
    data: {labels: scene.points.map(point => `${title(point)}: ${seconds(point.seconds)}`), datasets: sets},
    options: {
      indexAxis: 'y', animation: false, responsive: true, maintainAspectRatio: false,
      interaction: {mode: 'nearest', intersect: true},
      onClick: (event, hit) => { if (hit.length) select(state.scene, state.left, hit[0].index); },
      plugins: {
        legend: {position: 'top', align: 'start', labels: {color: color('--text'), boxWidth: 12}},
        tooltip: {callbacks: {label: item => `${item.dataset.label}: ${seconds(item.dataset.seconds[item.dataIndex])} (${item.parsed.x.toFixed(1)}%)`}},
      },
      scales: {
        x: {stacked: true, min: 0, max: 100, title: {display: true, text: 'share of wall time (%)', color: color('--text')},
            ticks: {color: color('--faint')}, grid: {color: color('--grid'), borderColor: color('--line')}},
        y: {stacked: true, ticks: {color: color('--text'), font: {size: 11}, autoSkip: false}, grid: {display: false, borderColor: color('--line')}},
      },
    },
  });
}

// A method's name beside its colour.
function methodCell(name) {
  const cell = element('td', methodLabel(name), 'text');
  const swatch = element('span', undefined, 'swatch');
  swatch.style.background = `var(${methodVariable(name)})`;
  cell.prepend(swatch);
  return cell;
}

const COLUMNS = [
  {name: 'scene', text: true, value: row => row.scene.name, key: row => row.s},
  {name: 'method', text: true, value: row => methodLabel(row.point.method)},
  {name: 'setting', text: true, value: row => row.point.setting, key: row => row.order},
  {name: 'wall time (s)', value: row => row.point.seconds},
  {name: 'cold (s)', value: row => row.point.cold_seconds},
  {name: 'runs', value: row => row.point.runs.length, show: value => value},
  {name: 'records', value: row => row.point.records || null, show: value => value === null ? '–' : value},
  ...['rel_rmse', 'bias', 'median', 'p99', 'tile_max'].map(
      error => ({name: error + ' (%)', error: true, value: row => row.point.errors[error] === null ? null : 100 * row.point.errors[error]})),
  {name: 'noise share', value: row => row.point.errors.noise_share, show: value => value.toFixed(2)},
];
const rows = data.scenes.flatMap((scene, s) => scene.points.map((point, p) => ({scene, s, point, p})));
rows.forEach((row, i) => { row.order = i; });
const sorting = {column: 0, descending: false};

function makeTable() {
  const head = element('tr');
  COLUMNS.forEach((column, i) => {
    const cell = element('th', undefined, column.text ? 'text' : '');
    cell.scope = 'col';
    const button = element('button', column.name);
    button.type = 'button';
    button.title = 'Sort';
    button.addEventListener('click', () => {
      sorting.descending = sorting.column === i && !sorting.descending;
      sorting.column = i;
      drawTable();
    });
    cell.append(button);
    head.append(cell);
  });
  const thead = element('thead');
  thead.append(head);
  $('table').append(thead, element('tbody'));
}

function drawTable() {
  const column = COLUMNS[sorting.column], key = column.key || column.value;
  const compare = (a, b) => {
    const x = key(a), y = key(b);
    if (x === null || y === null) return (x === null) - (y === null);
    const less = typeof x === 'string' ? x.localeCompare(y) : x - y;
    return (sorting.descending ? -less : less) || a.order - b.order;
  };
  const body = $('table').querySelector('tbody');
  body.replaceChildren(...[...rows].sort(compare).map(row => {
    const line = element('tr');
    for (const column of COLUMNS) {
      if (column.name === 'method') {
        line.append(methodCell(row.point.method));
        continue;
      }
      const value = column.value(row);
      const shown = column.text ? value : (column.show || digits)(value);
      const cell = element('td', shown, column.text ? 'text' : '');
      if (column.error && !row.point.errors.judged) cell.className = 'unjudged';
      line.append(cell);
    }
    if (row.s === state.scene) {
      line.classList.toggle('left', row.p === state.left);
      line.classList.toggle('right', row.p === state.right);
    }
    line.addEventListener('click', event => {
      const here = row.s === state.scene;
      if (event.shiftKey) select(row.s, row.p, here ? state.right : bestPoint(row.scene));
      else select(row.s, here ? state.left : REFERENCE, row.p);
    });
    return line;
  }));
  $('table').querySelectorAll('th').forEach((cell, i) => {
    if (i === sorting.column) cell.setAttribute('aria-sort', sorting.descending ? 'descending' : 'ascending');
    else cell.removeAttribute('aria-sort');
  });
}
