// Start: the simulators and other programs of the course, started and stopped without a terminal.
import {commandLine, el, fill} from '../app/dom.js';
import {button, Notice, Panel, setText} from './lib/parts.js';

const POLL_INTERVAL = 1000; // [ms]
const STATES = {stopped: '', running: 'runs', stopping: 'stops', failed: 'has ended with an error'};

export const help = [
  'Starts simulators, the marker tracker and rosbag on the machine of this page\'s server, and stops them, as Ctrl-C does.',
  'Each line can also be typed in a terminal. What is started here ends with the server of the page. Two simulators '
    + 'of the Robotont cannot run at once: the second one takes the place of the first.'];

export default class StartPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._rows = new Map();
    this._notice = new Notice();
    this._list = el('ul', {class: 'rows programs'});
    element.classList.add('without-ros');
    fill(element, this._notice.element, this._list);
    const timer = setInterval(() => document.hidden || this.ask(), POLL_INTERVAL); // also without a master
    this.scope.add(() => clearInterval(timer));
    this.ask();
  }

  // Ask the server for the state of all programs; with `wanted`, start or stop one first.
  async ask(wanted = null) {
    try {
      const answer = await fetch('programs', wanted ? {method: 'POST', body: JSON.stringify(wanted)} : {});
      if (!answer.ok) throw new Error(await answer.text());
      this._show(await answer.json());
      this._notice.say('');
    } catch (error) {
      this._notice.say(`The server of the page did not do that: ${error.message}`, true);
    }
  }

  _show(programs) {
    for (const [name, row] of this._rows) {
      if (!programs.some((program) => program.name === name)) { // the file of a bag has gone
        row.element.remove();
        this._rows.delete(name);
      }
    }
    for (const program of programs) {
      if (!this._rows.has(program.name)) {
        this._rows.set(program.name, new ProgramRow(this, program));
        this._list.append(this._rows.get(program.name).element);
      }
      this._rows.get(program.name).update(program);
    }
  }
}

class ProgramRow {
  constructor(panel, {name, title, about, command}) {
    this._panel = panel;
    this._title = title;
    this._said = '';
    this._state = el('span', {class: 'muted small', role: 'status'});
    this._start = button('Start', () => panel.ask({name, action: 'start'}), {'aria-label': `Start ${title}`});
    this._stop = button('Stop', () => panel.ask({name, action: 'stop'}), {'aria-label': `Stop ${title}`});
    this._output = el('pre', {class: 'small', hidden: true, tabIndex: 0, 'aria-label': `Output of ${title}`});
    this.element = el('li', {class: 'stack'},
      el('div', {class: 'row'}, el('h2', {}, title), this._start, this._stop, this._state),
      el('p', {class: 'muted'}, about), commandLine(command), this._output);
  }

  update({state, output}) {
    setText(this._state, STATES[state] ?? state);
    this._start.disabled = state === 'running' || state === 'stopping';
    this._stop.disabled = state !== 'running';
    this._output.hidden = !output;
    setText(this._output, output);
    if (state === 'failed' && this._said !== 'failed') this._panel.context.announce(`${this._title} has ended with an error`);
    this._said = state;
  }
}
