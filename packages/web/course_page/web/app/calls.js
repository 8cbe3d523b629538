// Service calls for a user: shows errors, and the command that does the same in a terminal.

import {el, fill} from './dom.js';

export class Caller {
  // `element` shows the command of the last call.
  constructor(context) {
    this._context = context;
    this._last = '';
    this.element = el('div', {class: 'command-now'});
  }

  // Call a service; return its answer, or show the error and return null.
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

// Return the arguments of a service as typed for rosservice.
function quoted(args) {
  const parts = Object.entries(args).map(([name, value]) => `${name}: ${typeof value === 'string' ? JSON.stringify(value) : value}`);
  return `"{${parts.join(', ').replaceAll('"', '\'')}}"`;
}
