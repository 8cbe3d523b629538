// Rows grouped by the first part of their names: /turtle1, /camera; names without a namespace come first.
import {el, store, stored} from '../../app/dom.js';
import {setText} from './parts.js';
import {clean} from './values.js';

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
