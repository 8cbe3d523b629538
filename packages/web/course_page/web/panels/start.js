// Start: the simulators and other programs of the course, started and stopped without a terminal.
import {commandLine, el, fill} from '../app/dom.js';
import {button, Notice, Panel, setText} from './lib/parts.js';

const POLL_INTERVAL = 1000; // [ms]
const STATES = {
  stopped: '', running: 'runs', elsewhere: 'runs, started in a terminal', stopping: 'stops',
  failed: 'failed: it has ended with an error'};

export const help = [
  'Starts simulators, the marker tracker and rosbag on the machine of this page\'s server, and stops them, as Ctrl-C does.',
  'Each line can also be typed in a terminal. What is started here ends with the server of the page. Two turtlesims, or '
    + 'two simulators of the Robotont, cannot run at once: the panel asks before it ends one for another.'];

export default class StartPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._rows = new Map();
    this._lost = false;
    this._notice = new Notice();
    this._list = el('ul', {class: 'rows programs'});
    element.classList.add('without-ros');
    fill(element, this._notice.element, this._list);
    const timer = setInterval(() => document.hidden || this.update(), POLL_INTERVAL); // also without a master
    this.scope.add(() => clearInterval(timer));
    this.update();
  }

  // Ask the server for the state of all programs; with `request`, start or stop one first. Return its question, or ''.
  async update(request = null) {
    try {
      const answer = await fetch('programs', request ? {method: 'POST', body: JSON.stringify(request)} : {});
      if (!answer.ok) throw new Error(await answer.text());
      const reply = await answer.json();
      if (reply.question) return reply.question;
      this._show(reply);
      if (request || this._lost) this._notice.say('');
      this._lost = false;
    } catch (error) {
      this._lost ||= !request;
      this._notice.say(`The server of the page did not do that: ${error.message}`, true);
    }
    return '';
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
  constructor(panel, {name, title, command}) {
    this._panel = panel;
    this._name = name;
    this._title = title;
    this._said = '';
    this._state = el('span', {class: 'muted small', role: 'status'});
    this._start = button('Start', () => this._ask(false), {'aria-label': `Start ${title}`});
    this._stop = button('Stop', () => panel.update({name, action: 'stop'}), {'aria-label': `Stop ${title}`});
    this._about = el('p', {class: 'muted'});
    this._text = el('p', {});
    this._instead = button('End it and start this', () => this._ask(true), {'aria-label': `End it and start ${title}`});
    this._keep = button('Keep it', () => this._show(''));
    this._question = el('div', {class: 'row notice question', hidden: true, role: 'alert'},
      this._text, this._instead, this._keep);
    this._reason = el('p', {class: 'notice reason', role: 'status', hidden: true});
    this._output = el('pre', {class: 'small', hidden: true, tabIndex: 0, 'aria-label': `Output of ${title}`});
    this._command = commandLine(command);
    this.element = el('li', {class: 'stack'},
      el('div', {class: 'row'}, el('h2', {}, title), this._start, this._stop, this._state), this._question,
      this._about, this._reason, this._command, this._output);
  }

  // Start the program; with `instead`, what is in its way ends first.
  async _ask(instead) {
    this._show('');
    this._start.disabled = true;
    this._show(await this._panel.update({name: this._name, action: 'start', instead}));
    this._panel.update();
  }

  _show(question) {
    this._question.hidden = !question;
    setText(this._text, question);
    if (question) this._keep.focus();
  }

  update({state, about, reason, output}) {
    setText(this._state, STATES[state] ?? state);
    setText(this._about, about);
    this._start.disabled = state === 'running' || state === 'stopping';
    this._stop.disabled = state !== 'running';
    this._reason.hidden = !reason;
    this._reason.classList.toggle('bad', state === 'failed');
    setText(this._reason, reason);
    this._output.hidden = !output;
    setText(this._output, output);
    if (state === 'failed' && this._said !== 'failed') {
      this._panel.context.announce(`${this._title} has ended with an error`);
    }
    this._said = state;
  }
}
