// Layouts: panels side by side with what they show, saved under a name in this browser.
import {besideOf, parseAddress} from './address.js';
import {CROSS, el, fill, icon, store, stored} from './dom.js';

const KEY = 'layouts';
const MOST = 30;
const LONGEST = 60; // characters of a name
const READY = {
  'Turtle, plot, graph': '#/turtle?plot.fields=/turtle1/pose/x,/turtle1/pose/y&beside=plot,graph',
  'Robotont, camera, frames, console': '#/robot?beside=image,frames,console',
};

// Return the saved layouts, {name: address}; what is in the browser may be anything.
export function savedLayouts(kept) {
  return Object.fromEntries(Object.entries(kept ?? {}).filter(([, address]) => /^#\/\w+/.test(address)).slice(0, MOST));
}

// Return the menu of layouts; `titleOf(id)` is the title of a panel.
export function layoutMenu(titleOf) {
  const name = el('input', {type: 'text', autocomplete: 'off', maxLength: LONGEST});
  const list = el('ul', {});
  const read = () => savedLayouts(stored(KEY));
  const write = (layouts) => {
    store(KEY, layouts);
    show();
  };
  const link = (title, address) => el('a', {href: address, on: {click: () => { menu.open = false; }}}, title);
  function show() {
    const saved = read();
    fill(list, Object.entries(READY).map(([title, address]) => el('li', {}, link(title, address))),
         Object.entries(saved).map(([title, address]) => el('li', {}, link(title, address), el('button', {
           class: 'plain', type: 'button', 'aria-label': `Delete the layout ${title}`, on: {click: () => {
             const {[title]: gone, ...others} = saved;
             write(others);
           }}}, icon(CROSS)))));
  }
  const save = (event) => {
    event.preventDefault();
    const {id, parameters} = parseAddress(location.hash);
    const usual = [id || 'turtle', ...besideOf(id, parameters)].map(titleOf).join(', ');
    write({...read(), [name.value.trim() || usual.slice(0, LONGEST)]: location.hash || '#/turtle'});
    name.value = '';
  };
  const menu = el('details', {class: 'layouts', on: {toggle: show}}, el('summary', {}, 'Layouts'),
    el('div', {class: 'card'}, list, el('form', {class: 'row', on: {submit: save}},
      el('label', {class: 'field'}, 'Name for what is shown now', name), el('button', {type: 'submit'}, 'Save'))));
  return menu;
}
