// Elements made in JavaScript. Everything from ROS becomes text here; this page never sets HTML.

// Return a new element. `properties`: `class`, `dataset`, `style` (an object), `on` ({event: listener}); names that start
// with aria- or are in ATTRIBUTES become attributes, all others properties. `children`: nodes, texts, or null for nothing.
export function el(name, properties = {}, ...children) {
  const element = document.createElement(name);
  assign(element, properties);
  append(element, children);
  return element;
}

// Return a new SVG element; all properties except `on` are attributes.
export function svg(name, properties = {}, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(properties)) {
    if (key === 'on') listen(element, value);
    else element.setAttribute(key, value);
  }
  append(element, children);
  return element;
}

// Return a drawing of 24 x 24 made of lines.
export function icon(path) {
  return svg('svg', {viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true'}, svg('path', {d: path}));
}

export const CROSS = 'M6 6l12 12M18 6L6 18';

// Replace the content of an element.
export function fill(element, ...children) {
  element.replaceChildren();
  append(element, children);
  return element;
}

const ATTRIBUTES = new Set(['role', 'for', 'list', 'colspan', 'rowspan', 'scope', 'inputmode', 'autocomplete']);

function assign(element, properties) {
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (key === 'class') element.className = value;
    else if (key === 'dataset') Object.assign(element.dataset, value);
    else if (key === 'style') Object.assign(element.style, value);
    else if (key === 'on') listen(element, value);
    else if (key.startsWith('aria-') || ATTRIBUTES.has(key)) element.setAttribute(key, value);
    else element[key] = value;
  }
}

function listen(element, listeners) {
  for (const [event, listener] of Object.entries(listeners)) element.addEventListener(event, listener);
}

function append(element, children) {
  for (const child of children.flat(Infinity)) {
    if (child !== null && child !== undefined && child !== false) element.append(child);
  }
}

// Return a hint for a panel that has nothing to show: a title, a sentence, and commands to type in a terminal.
export function emptyState(title, text, ...commands) {
  return el('div', {class: 'empty', role: 'note'}, el('h2', {}, title), el('p', {}, text), commands.map(commandLine));
}

// Return a line to type in a terminal, with a button that copies it.
export function commandLine(text) {
  const button = el('button', {
    class: 'copy', type: 'button', 'aria-label': `Copy ${text}`,
    on: {click: async () => {
      try {
        await navigator.clipboard.writeText(text);
        button.textContent = 'Copied';
      } catch {
        getSelection().selectAllChildren(code);
        button.textContent = 'Press Ctrl+C';
      }
      setTimeout(() => { button.textContent = 'Copy'; }, 1500);
    }},
  }, 'Copy');
  const code = el('code', {}, text);
  return el('div', {class: 'command'}, code, button);
}

// Return a function that calls `draw(time)` in the next frame of the screen, however often it is called until then.
export function inNextFrame(draw) {
  let handle = 0;
  const request = () => {
    handle ||= requestAnimationFrame((time) => {
      handle = 0;
      draw(time);
    });
  };
  request.cancel = () => {
    cancelAnimationFrame(handle);
    handle = 0;
  };
  return request;
}

// Return the value of a CSS variable such as '--line'; canvases take their colours from it.
export function cssColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Return the value that `store` has kept in this browser, or null; what is there may be anything.
export function stored(key) {
  try {
    return JSON.parse(localStorage.getItem(key));
  } catch {
    return null; // private windows have no storage
  }
}

export function store(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch { /* as above */ }
}

// Load a panel's style sheet once; its address is relative to index.html.
export function styleSheet(address) {
  if (![...document.styleSheets].some((sheet) => sheet.ownerNode?.getAttribute('href') === address)) {
    document.head.append(el('link', {rel: 'stylesheet', href: address}));
  }
}
