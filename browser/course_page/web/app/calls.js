// Calling services for a user: what is refused is shown, and what one would type in a terminal.

import {el, fill} from './dom.js';

export class Caller {
  // `element` shows the command of what was done last.
  constructor(context) {
    this._context = context;
    this._last = '';
    this.element = el('div', {class: 'command-now'});
  }

  // Call a service; return its answer, or null if it was refused, which the user is told.
  async call(service, args = {}) {
    this.show(`rosservice call ${service}${Object.keys(args).length ? ` ${quoted(args)}` : ''}`);
    try {
      return await this._context.ros.call(service, args);
    } catch (error) {
      this._context.toast(error.message, 'error');
      return null;
    }
  }

  // Show a command.
  show(text) {
    if (text !== this._last) fill(this.element, this._context.commandLine(text));
    this._last = text;
  }
}

// Return arguments of a service as one has to type them for rosservice.
function quoted(args) {
  const parts = Object.entries(args).map(([name, value]) => `${name}: ${typeof value === 'string' ? JSON.stringify(value) : value}`);
  return `"{${parts.join(', ').replaceAll('"', '\'')}}"`;
}
