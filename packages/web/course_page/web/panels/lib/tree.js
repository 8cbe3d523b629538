// The fields of a message as a tree whose branches open and close; only what is open is updated.
import {el} from '../../app/dom.js';
import {addressOf} from '../../app/address.js';
import {button, setText} from './parts.js';
import {elements, short} from './values.js';

const STEP = 50; // elements of an array that are shown at first, and added at each press
const MAX_ELEMENTS = 1000;

// A tree of a message of `types`; with a `topic`, numbers have a link to their plot.
export class Tree {
  constructor(types, topic = '') {
    this._types = types;
    this._topic = topic;
    this.element = el('div', {class: 'tree'});
    this._rows = types.fieldsOf().map((field) => this._row(field.name, field.type, field.array, field.name));
    this.element.append(...this._rows.map((row) => row.element));
    if (!this._rows.length) this.element.append(el('p', {class: 'muted'}, 'This type has no fields.'));
  }

  update(message) {
    this._types.fieldsOf().forEach((field, i) => this._rows[i].update(message[field.name]));
  }

  _row(name, type, array, path) {
    const compound = !this._types.isPrimitive(type);
    return array !== null || compound ? this._branch(name, type, array, path) : this._leaf(name, type, path);
  }

  _leaf(name, type, path) {
    const value = el('bdi', {class: 'value'}, '…');
    const plot = this._topic && type !== 'string'
      ? el('a', {class: 'plot-link', href: addressOf('plot', {fields: `${this._topic}/${path}`}),
                'aria-label': `plot ${path}`}, 'plot') : null;
    return {element: el('div', {class: 'leaf'}, el('span', {class: 'name', title: type}, name), value, plot),
            update: (now) => setText(value, short(now, type))};
  }

  _branch(name, type, array, path) {
    const value = el('bdi', {class: 'value'}, '…');
    const rows = [];
    const body = el('div', {class: 'branch'});
    let last;
    let limit = STEP;
    const more = button('Show more', () => {
      limit = Math.min(MAX_ELEMENTS, limit + STEP);
      show();
    }, {class: 'small', hidden: true});
    const details = el('details', {on: {toggle: () => show()}}, el('summary', {},
      el('span', {class: 'name', title: array === null ? type : `${type}[${array || ''}]`}, name), value), body, more);
    const show = () => {
      if (!details.open || last === undefined) return;
      if (array === null) this._showFields(type, path, rows, body, last);
      else this._showElements(type, path, rows, body, last, limit, more);
    };
    return {element: details, update: (now) => {
      last = now;
      setText(value, short(now, type, array !== null));
      show();
    }};
  }

  _showFields(type, path, rows, body, now) {
    const fields = this._types.fieldsOf(type);
    if (!rows.length) {
      rows.push(...fields.map((field) => this._row(field.name, field.type, field.array, `${path}/${field.name}`)));
      body.append(...rows.map((row) => row.element));
    }
    fields.forEach((field, i) => rows[i].update(now ? now[field.name] : undefined));
  }

  _showElements(type, path, rows, body, now, limit, more) {
    const all = elements(now, type);
    const count = Math.min(all.length, limit);
    while (rows.length > count) rows.pop().element.remove();
    while (rows.length < count) {
      rows.push(this._row(`[${rows.length}]`, type, null, `${path}[${rows.length}]`));
      body.append(rows[rows.length - 1].element);
    }
    rows.forEach((row, i) => row.update(all[i]));
    more.hidden = all.length <= count || limit >= MAX_ELEMENTS;
  }
}
