// Plots of numeric fields.
import {CROSS, cssColour, el, emptyState, fill, icon, styleSheet} from '../app/dom.js';
import {button, choice, labelled, loadScript, Notice, Panel, save, setText, suggestions} from './lib/parts.js';
import {expand, numbersAt, split} from './lib/fields.js';
import {merge, Samples, summary, toCsv} from './lib/samples.js';
import {messageTypes} from './lib/types.js';
import {clean, numberText} from './lib/values.js';

const UPLOT = new URL('../vendor/uplot/', import.meta.url);
const MAX_FIELDS = 6;
const DRAW = 66; // ms between two drawings
const RETRY = 1; // s until the next search for a missing topic
const POLL_INTERVAL = 5; // s between two updates of the suggestions
const TABLE = 500; // ms between two updates of the table
const ZOOM = 1.5;
const HEIGHT = 320; // px of a chart
const SMALL = 130; // px of one among several

export const help = [
  `Type a field such as /turtle1/pose/x, or several such as /turtle1/pose/x:y. Up to ${MAX_FIELDS} fields, the last 60 s. `
    + 'Drag over a part to zoom in, press Live to continue.', 'CSV saves what is shown, for a spreadsheet or Python.'];

export default class PlotPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._start = performance.now();
    this._now = 0; // s since then
    this._fields = []; // {text, topic, path, colour, state}
    this._topics = new Map(); // topic: {samples, end}
    this._known = new Map(); // topic: type
    this._charts = [];
    this._frozen = null; // {times and values of all fields, end} while paused
    this._range = null; // [from, to] where zoomed in
    this._make(element);
    styleSheet('vendor/uplot/uPlot.min.css');
    loadScript(new URL('uPlot.iife.min.js', UPLOT)).then(() => {
      this._uplot = window.uPlot;
      this._rebuild();
    }, (error) => this._notice.say(error.message, true));
    this._requested = expand(context.parameters.fields || '').slice(0, MAX_FIELDS);
    for (const text of this._requested) this._fields.push({text, colour: this._free()});
    this._list();
    this._resolve = this.scope.every(RETRY, () => this._resolveAll(), (error) => this._notice.say(error.message, true));
    this.scope.every(POLL_INTERVAL, () => this._suggest(), () => {});
    this.scope.listen(window, 'themechange', () => this._rebuild());
    const sizes = new ResizeObserver(() => this._resize());
    sizes.observe(this._box);
    this.scope.add(() => {
      sizes.disconnect();
      for (const topic of this._topics.values()) topic.end();
      for (const {chart} of this._charts) chart.destroy();
    });
    let due = 0;
    let drawn = 0;
    const frame = (time) => {
      if (this.scope.ended) return;
      requestAnimationFrame(frame);
      if (time < due || !this._uplot) return;
      due = time + DRAW;
      if (!this._frozen) this._draw();
      if (time > drawn) {
        drawn = time + TABLE;
        this._showTable();
      }
    };
    requestAnimationFrame(frame);
  }

  _make(element) {
    const [fields, setFields] = suggestions();
    this._setFields = setFields;
    this._input = labelled('Field', {placeholder: '/turtle1/pose/x', list: fields.id, on: {input: () => this._suggest()}});
    this._seconds = choice('Show', [['60', '60 s'], ['30', '30 s'], ['10', '10 s'], ['3', '3 s']], () => {
      this._range = null;
      this._draw();
    });
    this._kind = choice('Charts', [['one', 'one for all'], ['each', 'one each']], () => {
      this.context.setParameters({charts: this._kind.input.value === 'each' ? 'each' : ''});
      this._rebuild();
    });
    this._kind.input.value = this.context.parameters.charts === 'each' ? 'each' : 'one';
    this._pause = button('Pause', () => (this._frozen ? this._live() : this._freeze()), {'aria-pressed': 'false'});
    this._notice = new Notice();
    this._empty = el('div', {});
    this._box = el('div', {class: 'charts', role: 'img', 'aria-label': 'No plot yet'});
    this._rows = el('tbody', {});
    this._table = el('table', {class: 'legend', hidden: true}, el('thead', {}, el('tr', {}, ['Field', 'Now', 'Least', 'Largest', '']
      .map((text) => el('th', {scope: 'col'}, text || el('span', {class: 'unseen'}, 'Remove'))))), this._rows);
    const tools = el('div', {class: 'row'}, this._pause,
      button('+', () => this._zoom(1 / ZOOM), {'aria-label': 'Zoom in'}),
      button('−', () => this._zoom(ZOOM), {'aria-label': 'Zoom out'}),
      button('◀', () => this._move(-0.25), {'aria-label': 'Earlier'}),
      button('▶', () => this._move(0.25), {'aria-label': 'Later'}),
      button('CSV', () => this._save()));
    fill(element, el('form', {class: 'toolbar', on: {submit: (event) => {
      event.preventDefault();
      this._add(this._input.input.value);
    }}}, this._input.element, fields, el('button', {type: 'submit', class: 'primary'}, 'Add'), this._seconds.element,
    this._kind.element, tools), this._notice.element, this._empty, this._box, this._table);
  }

  _add(text) {
    const texts = expand(text).filter((name) => !this._fields.some((field) => field.text === name));
    if (!texts.length) {
      this._notice.say(text.trim() ? 'This field is shown already.' : 'Type a field first, such as /turtle1/pose/x.', true);
      this._input.input.focus();
      return;
    }
    this._notice.say('');
    for (const name of texts) {
      if (this._fields.length >= MAX_FIELDS) {
        this._notice.say(`${MAX_FIELDS} fields are shown already. Remove one first.`, true);
        break;
      }
      this._fields.push({text: name, colour: this._free()});
    }
    this._input.input.value = '';
    this._list();
    this._resolve();
  }

  _free() {
    const used = new Set(this._fields.map(({colour}) => colour));
    return [1, 2, 3, 4, 5, 6].find((number) => !used.has(number));
  }

  async _resolveAll() {
    const open = this._fields.filter(({path, failed}) => path === undefined && !failed);
    if (!open.length) return;
    this._known = new Map((await this.context.rosapi.topics()).map(({name, type}) => [name, type]));
    const before = JSON.stringify(open.map(({state}) => state));
    for (const field of open) await this._resolveOne(field);
    if (before !== JSON.stringify(open.map(({state}) => state))) this._list();
  }

  async _resolveOne(field) {
    const found = split(field.text, [...this._known.keys()].filter((name) => this._known.get(name)));
    if (!found) {
      field.state = 'no such topic yet';
      return;
    }
    const type = this._known.get(found.topic);
    let paths;
    try {
      paths = numbersAt(await messageTypes(this.context.ros, type), found.path);
    } catch (error) {
      field.failed = true;
      field.state = error.message;
      return;
    }
    const index = this._fields.indexOf(field);
    if (index < 0 || this.scope.ended) return;
    this._fields.splice(index, 1);
    const few = paths.filter((path) => !this._fields.some((other) => other.text === `${found.topic}/${path}`))
      .slice(0, MAX_FIELDS - this._fields.length);
    few.forEach((path, i) => {
      this._fields.splice(index + i, 0, {text: `${found.topic}/${path}`, colour: i ? this._free() : field.colour,
                                         topic: found.topic, path, state: 'no message yet'});
      this._subscribe(found.topic, type, path);
    });
    if (paths.length > few.length) this._notice.say(`${found.topic} has ${paths.length} numbers; ${few.length} of them are shown.`);
    this._list();
    this._rebuild();
  }

  _subscribe(name, type, path) {
    if (!this._topics.has(name)) {
      const samples = new Samples();
      const end = this.context.ros.subscribe(name, type, (message) => (
        samples.take(message, (performance.now() - this._start) / 1000)));
      this._topics.set(name, {samples, end});
    }
    this._topics.get(name).samples.add(path);
  }

  _remove(field) {
    this._fields = this._fields.filter((other) => other !== field);
    const topic = this._topics.get(field.topic);
    if (topic) {
      topic.samples.remove(field.path);
      if (!topic.samples.paths.length) {
        topic.end();
        this._topics.delete(field.topic);
      }
    }
    if (!this._fields.length) this._live();
    this._list();
    this._rebuild();
    this._input.input.focus();
  }

  // Show the list of fields as it is now.
  _list() {
    this.context.setParameters({fields: this._fields.map(({text}) => text).join(',')});
    fill(this._empty, this._fields.length ? [] : emptyState('Nothing to plot yet',
      'Type a field of a topic above, such as /turtle1/pose/x, and press Add. Or open this page from a terminal:',
      'rosrun rqt_plot rqt_plot /turtle1/pose/x:y'));
    this._table.hidden = this._box.hidden = !this._fields.length;
    fill(this._rows, this._fields.map((field) => {
      field.cells = [0, 1, 2].map(() => el('td', {class: 'number'}));
      field.cells[0].textContent = field.path === undefined ? '' : '…';
      return el('tr', {}, el('th', {scope: 'row'}, el('span', {class: `mark series-${field.colour}`}),
        el('bdi', {}, clean(field.text, 200)), field.path === undefined
          ? el('p', {class: `small ${field.failed ? 'error' : 'muted'}`}, field.state || 'looking for the topic …') : null),
      field.cells, el('td', {}, button(icon(CROSS), () => this._remove(field), {class: 'plain', 'aria-label': `Remove ${field.text}`})));
    }));
  }

  async _suggest() {
    const text = this._input.input.value.trim().split(/[\s,]+/).pop() || '';
    this._known = new Map((await this.context.rosapi.topics()).map(({name, type}) => [name, type]));
    const found = text.length > 1 && split(text.replace(/\/$/, ''), [...this._known.keys()]);
    const names = [...this._known.keys()].sort();
    if (!found || !this._known.get(found.topic)) {
      this._setFields(names);
      return;
    }
    try {
      const types = await messageTypes(this.context.ros, this._known.get(found.topic));
      this._setFields([...types.numericPaths().map((path) => `${found.topic}/${path}`), ...names]);
    } catch {
      this._setFields(names);
    }
  }

  get _plotted() {
    return this._fields.filter(({path}) => path !== undefined);
  }

  _rebuild() {
    if (!this._uplot) return;
    for (const {chart} of this._charts) chart.destroy();
    const fields = this._plotted;
    const groups = this._kind.input.value === 'each' ? fields.map((field) => [field]) : fields.length ? [fields] : [];
    this._charts = groups.map((group) => ({fields: group, chart: this._chart(group, groups.length > 1)}));
    this._draw();
  }

  _chart(group, small) {
    const muted = cssColour('--muted');
    const grid = {stroke: cssColour('--line'), width: 1};
    const axis = {stroke: muted, grid, ticks: grid, font: '12px system-ui, sans-serif'};
    return new this._uplot({
      width: Math.max(200, this._box.clientWidth), height: small ? SMALL : HEIGHT,
      legend: {show: false}, scales: {x: {time: false}, y: {range: yRange}},
      cursor: {drag: {x: true, y: false, setScale: false}, sync: {key: 'plot'}, points: {size: 7},
               bind: {dblclick: () => () => this._live()}},
      axes: [{...axis, splits: (_, __, min, max, step) => this._ticks(min, max, step),
              values: (_, values) => values.map((value) => `${numberText(Number((value - this._end).toFixed(4)))} s`)},
             {...axis, size: 62, space: 26, values: (_, values) => values.map(numberText)}],
      series: [{}, ...group.map(({text, colour}) => ({
        label: text, stroke: cssColour(`--series-${colour}`), width: 2, spanGaps: true, points: {show: false}}))],
      hooks: {setSelect: [(chart) => {
        const {left, width} = chart.select;
        if (width < 5) return;
        const ends = [chart.posToVal(left, 'x'), chart.posToVal(left + width, 'x')];
        chart.setSelect({left: 0, width: 0, top: 0, height: 0}, false);
        this._freeze();
        this._range = ends;
        this._draw();
      }]},
    }, [[], ...group.map(() => [])], this._box);
  }

  _resize() {
    for (const {chart} of this._charts) {
      const width = Math.max(200, this._box.clientWidth);
      if (width !== chart.width) chart.setSize({width, height: chart.height});
    }
  }

  // Return [times, values] of a field.
  _column(field) {
    if (this._frozen) return this._frozen.columns.get(field.text) || [[], []];
    const {samples} = this._topics.get(field.topic);
    return [samples.times, samples.values(field.path)];
  }

  // The time that the axis calls 0: now, or that of the pause.
  get _end() {
    return this._frozen ? this._frozen.end : this._now;
  }

  _window() {
    if (!this._frozen) this._now = (performance.now() - this._start) / 1000;
    return this._range || [this._end - Number(this._seconds.input.value), this._end];
  }

  // Return where the axis of time has ticks: in steps from its 0.
  _ticks(min, max, step) {
    const ticks = [];
    for (let i = Math.ceil((min - this._end) / step - 1e-6); this._end + i * step <= max + 1e-6; i += 1) ticks.push(this._end + i * step);
    return ticks;
  }

  _draw() {
    const [min, max] = this._window();
    for (const {chart, fields} of this._charts) {
      chart.batch(() => {
        chart.setData(merge(fields.map((field) => this._column(field))), false);
        chart.setScale('x', {min, max});
      });
    }
  }

  _showTable() {
    const [from, to] = this._window();
    const texts = [];
    for (const field of this._plotted) {
      const [times, values] = this._column(field);
      const {last, min, max} = summary(times, values, from, to);
      const none = times.length ? 'NaN' : '…';
      [last, min, max].forEach((value, i) => setText(field.cells[i], value === null ? none : numberText(value)));
      texts.push(`${field.text} from ${min === null ? 'nothing' : numberText(min)} to ${max === null ? 'nothing' : numberText(max)}`);
    }
    this._box.setAttribute('aria-label', texts.length ? `Plot: ${texts.join('; ')}. The table below says the same.` : 'No plot yet');
  }

  _freeze() {
    if (this._frozen || !this._plotted.length) return;
    const copies = new Map();
    const copy = (list) => {
      if (!copies.has(list)) copies.set(list, list.slice());
      return copies.get(list);
    };
    const columns = new Map(this._plotted.map((field) => [field.text, this._column(field).map(copy)]));
    this._frozen = {columns, end: (performance.now() - this._start) / 1000};
    this._pause.textContent = 'Live';
    this._pause.setAttribute('aria-pressed', 'true');
    this.context.announce('Paused');
  }

  _live() {
    this._range = null;
    if (this._frozen) this.context.announce('Live again');
    this._frozen = null;
    this._pause.textContent = 'Pause';
    this._pause.setAttribute('aria-pressed', 'false');
    this._draw();
  }

  _zoom(factor) {
    this._freeze();
    const [from, to] = this._window();
    const half = (to - from) / 2 * factor;
    this._range = [(from + to) / 2 - half, (from + to) / 2 + half];
    this._draw();
    this._showTable();
  }

  _move(part) {
    this._freeze();
    const [from, to] = this._window();
    this._range = [from + (to - from) * part, to + (to - from) * part];
    this._draw();
    this._showTable();
  }

  _save() {
    if (!this._plotted.length) {
      this._notice.say('There is nothing to save yet.', true);
      return;
    }
    const [from, to] = this._window();
    const [times, ...columns] = merge(this._plotted.map((field) => this._column(field)));
    const rows = times.map((time, i) => i).filter((i) => times[i] >= from && times[i] <= to);
    const start = (performance.timeOrigin + this._start) / 1000;
    const chosen = [times.map((time) => start + time), ...columns].map((values) => rows.map((i) => values[i]));
    save('plot.csv', toCsv(this._plotted.map(({text}) => text), chosen), 'text/csv');
    this._notice.say(`Saved ${rows.length} lines as plot.csv; times are those of this machine, in seconds since 1970.`);
  }
}

// Return the range of the y axis for data from `min` to `max`: a margin, and room where a value does not change.
function yRange(_, min, max) {
  if (min === null || max === null) return [0, 1];
  const room = Math.max((max - min) * 0.08, Math.abs(max) * 1e-6, 1e-6);
  return max - min < room ? [min - Math.max(room, Math.abs(min) * 0.05), max + Math.max(room, Math.abs(max) * 0.05)]
    : [min - room, max + room];
}
