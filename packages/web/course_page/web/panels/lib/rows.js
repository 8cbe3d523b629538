// Panels with a list of rows that open: topics, nodes, services, parameters.
import {el, emptyState, fill, store, stored} from '../../app/dom.js';
import {labelled, Notice, Panel, setText} from './parts.js';
import {clean} from './values.js';

// A list with a filter. `kind`: the rows in the plural; `parts`: of a row, that the filter searches; `hint`: [title, text,
// command] while there are none.
export class RowsPanel extends Panel {
  constructor(context, kind, parts, hint) {
    super(context);
    this.rows = new Map(); // name: Row
    this._kind = kind;
    this._parts = parts;
    this._hint = hint;
    this._filter = labelled('Filter', {type: 'search', value: context.parameters.filter || '',
                                       placeholder: `a part of a ${parts}`, on: {input: () => this.arrange()}});
    this._count = el('p', {class: 'muted small', role: 'status'});
    this.notice = new Notice();
    this._empty = el('div', {});
    this.list = new NamespaceList(kind);
  }

  // Show everything in `element`: `tools` beside the filter, `before` and `after` the list.
  build(element, {tools = [], links = [], before = [], after = []} = {}) {
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, tools, this._count, links), this.notice.element, before,
         this._empty, this.list.element, after);
  }

  // Whether the row `name` belongs to the list; subclasses also get the words of the filter.
  isUsual() {
    return true;
  }

  remove(row) {
    row.element.remove();
    this.rows.delete(row.name);
  }

  // Open the row of a name, and its namespace.
  reveal(name) {
    this.list.reveal(name);
    this.rows.get(name).open();
  }

  arrange() {
    const words = this._filter.input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const rows = [...this.rows.values()];
    const usual = rows.filter((row) => this.isUsual(row.name, words));
    const shown = new Set(usual.filter((row) => words.every((word) => row.searched.toLowerCase().includes(word))));
    for (const row of rows) row.element.hidden = !shown.has(row) && !row.stays;
    this.list.arrange(rows, words.length > 0);
    setText(this._count, words.length ? `${shown.size} of ${usual.length} ${this._kind}` : `${usual.length} ${this._kind}`);
    fill(this._empty, !usual.length ? emptyState(...this._hint)
      : shown.size ? [] : el('p', {class: 'muted'}, `No ${this._parts} contains this. Clear the filter to see all.`));
  }
}

// A row with a `body` below its head; subclasses have `open` and `close`, which get true if the user asks for it.
export class Row {
  // `head`: elements beside the name.
  constructor(panel, name, ...head) {
    this.name = this.searched = name;
    this.stays = false; // listed although the filter does not match
    this.panel = panel;
    this.body = el('div', {class: 'row-body stack', hidden: true});
    this._button = el('button', {type: 'button', class: 'row-head', 'aria-expanded': 'false',
                                 on: {click: () => (this.body.hidden ? this.open(true) : this.close(true))}},
                      el('bdi', {class: 'row-name'}, clean(name, 300)), head);
    this.element = el('li', {}, this._button, this.body);
  }

  expand(open) {
    this.body.hidden = !open;
    this._button.setAttribute('aria-expanded', String(open));
  }
}

// Return the namespace under which a name is listed; '/' for one without.
export function namespaceOf(name) {
  const parts = name.split('/');
  return parts.length > 2 ? `/${parts[1]}` : '/';
}

// A list of rows, {name, element}. What the user closes stays closed in this browser, except for the rows of a search.
export class NamespaceList {
  // `id`: under which the closed ones are kept.
  constructor(id) {
    this._key = `closed namespaces of ${id}`;
    const closed = stored(this._key);
    this._closed = new Set(Array.isArray(closed) ? closed : []);
    this._groups = new Map(); // namespace: {element, summary, rows}
    this.element = el('div', {class: 'namespaces'});
  }

  // Show rows in the order of their names, without those that are hidden; `searching`: all namespaces are open.
  arrange(rows, searching = false) {
    const sorted = new Map();
    for (const row of [...rows].sort((a, b) => (a.name < b.name ? -1 : 1))) {
      const namespace = namespaceOf(row.name);
      if (!sorted.has(namespace)) sorted.set(namespace, []);
      sorted.get(namespace).push(row);
    }
    for (const [namespace, {element}] of this._groups) {
      if (!sorted.has(namespace)) {
        element.remove();
        this._groups.delete(namespace);
      }
    }
    [...sorted.keys()].sort().forEach((namespace, at) => {
      const group = this._group(namespace);
      put(this.element, group.element, at);
      const own = sorted.get(namespace);
      own.forEach(({element}, index) => put(group.rows, element, index));
      const shown = own.filter(({element}) => !element.hidden).length;
      group.element.hidden = !shown;
      group.summary.hidden = sorted.size === 1;
      setText(group.summary, `${clean(namespace, 100)} (${shown})`);
      group.element.open = searching || sorted.size === 1 || !this._closed.has(namespace);
    });
  }

  // Open the namespace of a name.
  reveal(name) {
    this._keep(namespaceOf(name), true);
    const group = this._groups.get(namespaceOf(name));
    if (group) group.element.open = true;
  }

  _group(namespace) {
    if (!this._groups.has(namespace)) {
      const rows = el('ul', {class: 'rows'});
      const summary = el('summary', {on: {click: () => this._keep(namespace, !element.open)}}); // before it changes
      const element = el('details', {class: 'namespace', open: true}, summary, rows);
      this._groups.set(namespace, {element, summary, rows});
    }
    return this._groups.get(namespace);
  }

  _keep(namespace, open) {
    if (open) this._closed.delete(namespace);
    else this._closed.add(namespace);
    store(this._key, [...this._closed]);
  }
}

function put(parent, element, index) {
  if (parent.children[index] !== element) parent.insertBefore(element, parent.children[index] ?? null);
}
