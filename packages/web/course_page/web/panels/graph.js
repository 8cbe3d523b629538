// The graph of nodes and topics, as a drawing and as a table.
import {el, emptyState, fill, svg} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {button, choice, labelled, Notice, Panel, setText} from './lib/parts.js';
import {clean, shortName} from './lib/values.js';
import {graphOf, System} from './lib/system.js';
import dagre from '../vendor/dagre/dagre.esm.js';

const FONT = '13px system-ui, sans-serif';
const ZOOM = 1.25; // at each press
const LEAST = 0.02; // of the graph that a zoomed view shows
const STEP = 60; // px that an arrow key moves the view
const LARGEST = 1.4; // scale: small graphs are not blown up
const SMALLEST = 0.5; // scale at first; what does not fit then is reached by moving
const HEIGHT = 34; // px of a node
const PADDING = 26; // px beside its name
const MAX_PARTS = 400; // nodes and edges that are laid out, which takes up to about a second

export const help = [
  'Ellipses are nodes, rectangles are topics; arrows say where messages go. It is drawn again as soon as a node '
    + 'comes or goes. Choose one to see what it is connected with; drag, or use the arrow keys, + and -, to move and zoom.',
  'In a terminal: rosnode list, rosnode info.'];

export default class GraphPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._system = null;
    this._chosen = '';
    this._drawn = '';
    this._view = null; // {x, y, width, height}
    this._moved = false; // whether the user has moved the view, which new nodes do not change then
    const given = context.parameters;
    const change = () => {
      context.setParameters({filter: this._filter.input.value.trim(), show: this._kind.input.value === 'all' ? '' : 'nodes',
                             tools: this._debug.input.checked ? '1' : '', loose: this._loose.input.checked ? '' : '0'});
      this._draw();
    };
    this._filter = labelled('Filter', {type: 'search', placeholder: 'a part of a name', value: given.filter || '', on: {input: change}});
    this._kind = choice('Show', [['all', 'Nodes and topics'], ['nodes', 'Only nodes']], change);
    this._kind.input.value = given.show === 'nodes' ? 'nodes' : 'all';
    this._debug = labelled('Tools', {type: 'checkbox', checked: Boolean(given.tools), on: {change},
                                     title: 'rosout, the server of this page, rostopic and the like, and their topics'});
    this._loose = labelled('Topics with one side only', {type: 'checkbox', checked: given.loose !== '0', on: {change}});
    this._notice = new Notice();
    this._summary = el('p', {class: 'muted small'});
    this._empty = el('div', {});
    this._canvas = svg('svg', {class: 'graph', role: 'application', tabindex: 0, 'aria-roledescription': 'graph',
                               preserveAspectRatio: 'xMidYMid meet'});
    this._details = el('div', {class: 'card', hidden: true, 'aria-live': 'polite'});
    this._table = el('div', {});
    this._box = el('div', {class: 'graph-box'}, this._canvas, el('div', {class: 'graph-buttons'},
      button('+', () => this._zoom(1 / ZOOM), {'aria-label': 'Larger'}),
      button('−', () => this._zoom(ZOOM), {'aria-label': 'Smaller'}),
      button('Fit', () => this._fit(), {'aria-label': 'Fit: show all of it'})));
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, this._kind.element, this._debug.element,
                     this._loose.element), this._notice.element, this._summary, this._empty, this._box, this._details,
         el('details', {class: 'card'}, el('summary', {}, 'The graph as a table'), this._table));
    this._listen();
    const measure = document.createElement('canvas').getContext('2d');
    measure.font = FONT;
    this._widthOf = (text) => measure.measureText(text).width;
    new System(this.scope, context.rosapi, (system) => this._changed(system),
               (error) => this._notice.say(error.message, true));
    const sizes = new ResizeObserver(() => this._draw());
    sizes.observe(this._box);
    this.scope.add(() => sizes.disconnect());
  }

  _changed(system) {
    const before = this._system ? new Set(this._names) : null;
    this._system = system;
    this._names = [...system.nodes.keys()];
    this._notice.say('');
    if (before) {
      const come = this._names.filter((name) => !before.has(name));
      const gone = [...before].filter((name) => !system.nodes.has(name));
      const text = [come.length ? `New: ${come.join(', ')}.` : '', gone.length ? `Gone: ${gone.join(', ')}.` : ''].join(' ');
      if (text.trim()) this.context.announce(text);
    }
    this._draw();
  }

  _draw() {
    if (!this._system) return;
    const graph = graphOf(this._system, {debug: this._debug.input.checked, topics: this._kind.input.value === 'all',
                                         loose: this._loose.input.checked, filter: this._filter.input.value.trim()});
    const {clientWidth: width, clientHeight: height} = this._canvas;
    const key = JSON.stringify([graph, width, height]);
    if (key === this._drawn) return;
    this._drawn = key;
    const best = (shown) => largest([false, true].map((down) => layOut(shown, this._widthOf, down)), width, height);
    let drawing = best(graph);
    let hint = '';
    if (!drawing && graph.topics.length) {
      drawing = best(graphOf(this._system, {debug: this._debug.input.checked, topics: false,
                                            filter: this._filter.input.value.trim()}));
      hint = ' There are too many topics to draw: only nodes are shown. Filter for a name.';
    }
    const count = (number, word) => `${number} ${word}${number === 1 ? '' : 's'}`;
    const text = `${count(graph.nodes.length, 'node')}, ${count(graph.topics.length, 'topic')}`;
    setText(this._summary, drawing ? `${text}.${hint}` : `${text} are too many to draw. Filter for a name, or read the table.`);
    this._canvas.setAttribute('aria-label', `Graph of ${text}. The table below says the same.`);
    const some = graph.nodes.length > 0;
    this._box.hidden = !some || !drawing;
    fill(this._empty, some ? [] : this._filter.input.value.trim()
      ? el('p', {class: 'muted'}, 'No name contains this. Clear the filter to see all.')
      : emptyState('No nodes yet', 'Only roscore and the server of this page are running. Start one, and it appears here.',
                   'rosrun turtlesim turtlesim_node'));
    if (drawing && some) this._paint(drawing);
    this._showTable(graph);
    this._showDetails();
  }

  _paint(drawing) {
    const before = this._size;
    this._size = {width: Math.max(drawing.width, 1), height: Math.max(drawing.height, 1)};
    const points = (edge) => edge.points.map(({x, y}) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' ');
    this._shapes = new Map();
    this._lines = drawing.edges.map((edge) => ({...edge, element: svg('g', {class: 'edge'},
      svg('polyline', {points: points(edge), 'marker-end': 'url(#arrow)'}),
      edge.label ? svg('text', {x: edge.x, y: edge.y - 6}, clean(shortName(edge.label), 60)) : null)}));
    fill(this._canvas, svg('defs', {}, svg('marker', {
      id: 'arrow', viewBox: '0 0 10 10', refX: 9, refY: 5, markerWidth: 8, markerHeight: 8, orient: 'auto-start-reverse'},
    svg('path', {d: 'M0 0 10 5 0 10z'}))), this._lines.map((line) => line.element), drawing.nodes.map((node) => {
      const {key, name, x, y, width, height} = node;
      const isNode = key.startsWith('n:');
      const shape = isNode ? svg('ellipse', {cx: x, cy: y, rx: width / 2, ry: height / 2})
        : svg('rect', {x: x - width / 2, y: y - height / 2, width, height, rx: 4});
      const element = svg('g', {class: isNode ? 'node' : 'topic', on: {click: () => this._choose(key)}}, shape,
                          svg('text', {x, y}, clean(shortName(name), 60)), svg('title', {}, clean(name, 300)));
      this._shapes.set(key, element);
      return element;
    }));
    if (!this._moved || !before) this._view = null;
    this._show();
    this._highlight();
  }

  _fit() {
    this._moved = false;
    this._view = {...this._all};
    this._show();
  }

  // Show the view, at first all of the drawing, but not smaller than can be read.
  _show() {
    const {clientWidth: width, clientHeight: height} = this._canvas;
    if (!width) return;
    const fit = Math.min(LARGEST, width / this._size.width, height / this._size.height);
    const at = (scale) => ({x: (this._size.width - width / scale) / 2, y: (this._size.height - height / scale) / 2,
                            width: width / scale, height: height / scale});
    this._all = at(fit);
    const {x, y, width: w, height: h} = this._view ||= at(Math.max(fit, SMALLEST));
    this._canvas.setAttribute('viewBox', `${x} ${y} ${w} ${h}`);
  }

  _zoom(factor, at = null) {
    const {_view: view} = this;
    if (!view) return;
    this._moved = true;
    const width = Math.max(this._all.width * LEAST, Math.min(this._all.width * 2, view.width * factor));
    const ratio = width / view.width;
    const [cx, cy] = at || [view.x + view.width / 2, view.y + view.height / 2];
    this._view = {x: cx - (cx - view.x) * ratio, y: cy - (cy - view.y) * ratio, width, height: view.height * ratio};
    this._show();
  }

  _move(dx, dy) {
    const {_view: view} = this;
    if (!view) return;
    this._moved = true;
    const scale = view.width / this._canvas.clientWidth;
    this._view = {...view, x: view.x + dx * scale, y: view.y + dy * scale};
    this._show();
  }

  _listen() {
    const fingers = new Map();
    let moved = 0;
    const {_canvas: canvas} = this;
    canvas.addEventListener('pointerdown', (event) => {
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      moved = 0;
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY];
      const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
      const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
      moved += distance(before, now);
      if (moved < 4) return;
      if (others.length) this._zoom(distance(before, others[0]) / Math.max(1, distance(now, others[0])));
      else this._move(before[0] - now[0], before[1] - now[1]);
      fingers.set(event.pointerId, now);
      if (!canvas.hasPointerCapture(event.pointerId)) canvas.setPointerCapture(event.pointerId);
    });
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && !event.metaKey) return; // the page scrolls
      event.preventDefault();
      const box = canvas.getBoundingClientRect();
      const {_view: view} = this;
      if (!view) return;
      this._zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM, [view.x + (event.clientX - box.x) / box.width * view.width,
                                                      view.y + (event.clientY - box.y) / box.height * view.height]);
    }, {passive: false});
    canvas.addEventListener('keydown', (event) => {
      const keys = {ArrowLeft: () => this._move(-STEP, 0), ArrowRight: () => this._move(STEP, 0),
                    ArrowUp: () => this._move(0, -STEP), ArrowDown: () => this._move(0, STEP),
                    '+': () => this._zoom(1 / ZOOM), '-': () => this._zoom(ZOOM), 0: () => this._fit(),
                    Escape: () => this._choose('')};
      if (!(event.key in keys) || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  _choose(key) {
    this._chosen = key === this._chosen ? '' : key;
    this._highlight();
    this._showDetails();
  }

  _highlight() {
    if (!this._shapes) return;
    const near = new Set([this._chosen]);
    for (const {from, to, element} of this._lines) {
      const touches = this._chosen && (from === this._chosen || to === this._chosen);
      element.classList.toggle('chosen', Boolean(touches));
      if (touches) [from, to].forEach((end) => near.add(end));
    }
    const active = this._shapes.has(this._chosen);
    for (const [key, element] of this._shapes) {
      element.classList.toggle('chosen', key === this._chosen);
      element.classList.toggle('faint', active && !near.has(key));
    }
  }

  _showDetails() {
    const name = this._chosen.slice(2);
    const isNode = this._chosen.startsWith('n:');
    const known = isNode ? this._system.nodes.has(name) : this._chosen && this._system.types.has(name);
    this._details.hidden = !known;
    if (!known) return;
    const title = el('h2', {}, el('bdi', {}, clean(name, 200)));
    if (isNode) {
      const {publishing, subscribing} = this._system.nodes.get(name);
      fill(this._details, title, el('p', {}, `Publishes ${join(publishing, 'nothing')}.`), el('p', {}, `Subscribes to ${join(subscribing, 'nothing')}.`),
           el('p', {}, el('a', {href: addressOf('nodes', {node: name})}, 'All of this node')));
    } else {
      const side = (kind) => [...this._system.nodes].filter(([, node]) => node[kind].includes(name)).map(([node]) => node);
      fill(this._details, title, el('p', {class: 'muted'}, clean(this._system.types.get(name) || 'type unknown', 100)),
           el('p', {}, `From ${join(side('publishing'))} to ${join(side('subscribing'))}.`),
           el('p', {}, el('a', {href: addressOf('topics', {open: name})}, 'Its messages')));
    }
  }

  // Show, for each topic, from where its messages come and where they go.
  _showTable(graph) {
    const shown = new Set(graph.nodes);
    const rows = new Map(graph.topics.map((name) => [name, {from: [], to: []}]));
    if (this._kind.input.value === 'all') {
      for (const [from, to] of graph.edges) {
        if (from.startsWith('n:')) rows.get(to.slice(2)).from.push(from.slice(2));
        else rows.get(from.slice(2)).to.push(to.slice(2));
      }
      fill(this._table, rows.size ? table(['Topic', 'From', 'To'], [...rows].slice(0, 500).map(([name, {from, to}]) => (
        [name, join(from), join(to)]))) : el('p', {class: 'muted'}, 'No topics.'));
    } else {
      fill(this._table, table(['From', 'To', 'Topic'], graph.edges.slice(0, 500).map(([from, to, label]) => (
        [from.slice(2), to.slice(2), label]))));
    }
    const alone = [...shown].filter((name) => !graph.edges.some(([from, to]) => from === `n:${name}` || to === `n:${name}`));
    if (alone.length) this._table.append(el('p', {class: 'muted'}, `Not connected: ${join(alone)}.`));
  }
}

function table(heads, rows) {
  return el('table', {}, el('thead', {}, el('tr', {}, heads.map((text) => el('th', {scope: 'col'}, text)))),
            el('tbody', {}, rows.map((cells) => el('tr', {}, cells.map((text) => el('td', {}, el('bdi', {}, clean(text, 300))))))));
}

function join(names, none = 'nobody') {
  return names.length ? names.map((name) => clean(name, 100)).join(', ') : none;
}

// Return {width, height, nodes: [{key, name, x, y, width, height}], edges: [{from, to, label, points, x, y}]}, or null if
// the graph is too large. `widthOf(text)` is that of a text [px]; `down`: from top to bottom instead of left to right.
export function layOut({nodes, topics, edges}, widthOf, down = false) {
  if (nodes.length + topics.length + edges.length > MAX_PARTS) return null;
  const graph = new dagre.graphlib.Graph({multigraph: true});
  graph.setGraph({rankdir: down ? 'TB' : 'LR', nodesep: 18, ranksep: 46, edgesep: 10, marginx: 12, marginy: 12});
  graph.setDefaultEdgeLabel(() => ({}));
  const all = [...nodes.map((name) => [`n:${name}`, name]), ...topics.map((name) => [`t:${name}`, name])];
  for (const [key, name] of all) {
    graph.setNode(key, {name, width: widthOf(shortName(name)) + PADDING, height: HEIGHT});
  }
  for (const [from, to, label] of edges) {
    graph.setEdge(from, to, label ? {label, width: widthOf(shortName(label)), height: 14, labelpos: 'c'} : {}, label || undefined);
  }
  dagre.layout(graph);
  const {width, height} = graph.graph();
  return {
    width: Number.isFinite(width) ? width : 0, height: Number.isFinite(height) ? height : 0,
    nodes: graph.nodes().map((key) => {
      const {name, x, y, width: w, height: h} = graph.node(key);
      return {key, name, x, y, width: w, height: h};
    }),
    edges: graph.edges().map((edge) => {
      const {label = '', points, x, y} = graph.edge(edge);
      return {from: edge.v, to: edge.w, label, points, x, y};
    }),
  };
}

// Return the drawing that appears largest in a frame; null if there is none.
export function largest(drawings, width, height) {
  const scale = (drawing) => Math.min((width || 1) / drawing.width, (height || 1) / drawing.height);
  return drawings.filter(Boolean).reduce((best, other) => (best && scale(best) >= scale(other) ? best : other), null);
}
