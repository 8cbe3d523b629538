// Grade: a program of the user is graded, and its verdict shown.
import {commandLine, el, emptyState, fill} from '../app/dom.js';
import {button, choice, Notice, Panel, setText} from './lib/parts.js';
import {clean} from './lib/values.js';

const POLL_INTERVAL = 1000; // [ms]
const KINDS = {passed: 'good', failed: 'bad', undecided: 'busy'};

export const help = [
  'Grades a program as ./run grade does: with a master and a simulator of its own, which do not touch what you see in the '
    + 'other panels. One program is graded at a time.',
  'The list has the programs in the folder in which the page was started and in the workspaces that were sourced there, '
    + 'the newest first.'];

export default class GradePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._shown = '';
    this._running = false;
    this._notice = new Notice();
    this._exercise = choice('Exercise', [], () => this._describe());
    this._program = choice('Program', [], () => this._choose());
    this._grade = button('Grade', () => this._post({exercise: this._exercise.input.value, program: this._program.input.value}),
                         {class: 'primary', disabled: true});
    this._stop = button('Stop', () => this._post({}), {disabled: true});
    this._asks = el('p', {class: 'muted asks'});
    this._missing = el('div', {});
    this._state = el('p', {role: 'status'});
    this._verdict = el('div', {class: 'stack'});
    element.classList.add('without-ros');
    fill(element, el('div', {class: 'toolbar'}, this._exercise.element, this._program.element, this._grade, this._stop,
                     button('Look for programs', () => this._list())),
         this._asks, this._notice.element, this._missing, this._state, this._verdict);
    const timer = setInterval(() => document.hidden || this._update(), POLL_INTERVAL); // also without a master
    this.scope.add(() => clearInterval(timer));
    this._list();
    this._update();
  }

  async _fetch(address, options = {}) {
    const answer = await fetch(address, options);
    if (!answer.ok) throw new Error(await answer.text());
    return answer.json();
  }

  async _list() {
    try {
      const {exercises, programs, folders, error} = await this._fetch('grading/choices');
      if (this.scope.ended) return;
      this._exercises = new Map(exercises.map((exercise) => [exercise.name, exercise]));
      const {parameters} = this.context;
      this._offer(this._exercise.input, exercises.map(({name, title}) => [name, `${title} (${name})`]), parameters.exercise);
      this._offer(this._program.input, programs.map((path) => [path, shortPath(path, folders)]), parameters.program);
      this._describe();
      if (error) this._notice.say(`There is no grader here: ${clean(error, 600, true)}`, true);
      fill(this._missing, programs.length ? [] : emptyState('No program yet', `Save a program below ${
        folders.length ? folders.map((folder) => clean(folder, 300)).join(' or ') : 'the folder in which the page was started'
      }, then press Look for programs. Or start the page in the folder of your programs:`, './run view'));
    } catch (error) {
      this._notice.say(`The lists did not come: ${error.message}`, true);
    }
  }

  _offer(input, choices, preferred) {
    const before = input.value || preferred;
    fill(input, choices.map(([value, text]) => el('option', {value}, clean(text, 200))));
    if (choices.some(([value]) => value === before)) input.value = before;
  }

  _describe() {
    setText(this._asks, clean(this._exercises?.get(this._exercise.input.value)?.asks ?? '', 2000));
    this._choose();
  }

  _choose() {
    this.context.setParameters({exercise: this._exercise.input.value, program: this._program.input.value});
    this._enable();
  }

  _enable() {
    this._grade.disabled = this._running || !this._exercise.input.value || !this._program.input.value;
  }

  _post(request) {
    this._notice.say('');
    return this._update({method: 'POST', body: JSON.stringify(request)});
  }

  async _update(options = {}) {
    try {
      const state = await this._fetch('grading', options);
      if (!this.scope.ended) this._show(state);
    } catch (error) {
      this._notice.say(`The server of the page did not do that: ${error.message}`, true);
    }
  }

  _show(grading) {
    const {state, number, exercise, program, seconds, log} = grading;
    const before = this._running;
    this._running = state === 'running' || state === 'stopping';
    this._stop.disabled = state !== 'running';
    this._enable();
    const what = `${exercise}: ${clean(program.split('/').pop(), 100)}`;
    if (this._running) {
      setText(this._state, `${what} ${state === 'stopping' ? 'is stopped' : 'is being graded'}, ${seconds.toFixed(0)} s. ${clean(log.split('\n').pop(), 300)}`);
      fill(this._verdict);
      this._shown = '';
      return;
    }
    setText(this._state, '');
    if (state === 'none' || this._shown === `${number}`) return;
    this._shown = `${number}`;
    const verdict = verdictOf(grading);
    fill(this._verdict, report(what, verdict, grading));
    if (before) this.context.announce(`${what}: ${verdict.text}`);
  }
}

function report(what, {text, kind, hints, checks, notes}, {result, command, output, picture, number, log}) {
  return el('section', {class: 'card verdict', 'aria-label': `Verdict on ${what}`},
    el('div', {class: 'row'}, el('h2', {}, clean(result?.title ?? what, 200)), el('strong', {class: `pill ${kind}`}, text)),
    el('p', {class: 'muted small'}, what),
    hints.map((hint) => el('p', {class: 'notice'}, clean(hint, 1000))),
    result ? null : el('pre', {class: 'small', tabIndex: 0, 'aria-label': 'Output of the grader'}, clean(log, 4000, true)),
    checks.length ? el('table', {}, el('thead', {}, el('tr', {}, ['Points', 'Asked', 'Seen'].map((title) => el('th', {scope: 'col'}, title)))),
                       el('tbody', {}, checks.map(({points, of, asked, seen}) => el('tr', {},
                         el('td', {class: 'number'}, `${points} of ${of}`), el('td', {}, clean(asked, 1000)), el('td', {}, clean(seen, 1000)))))) : null,
    picture ? el('img', {src: `grading/path.png?number=${number}`, alt: 'The path; the part that counted is green'}) : null,
    output ? el('details', {}, el('summary', {}, 'What the program has printed, with times'),
                el('pre', {class: 'small', tabIndex: 0, 'aria-label': 'Output of the program'}, clean(output, 60000, true))) : null,
    notes.map((note) => el('p', {class: 'muted small'}, clean(note, 600))),
    el('p', {class: 'muted small'}, result ? 'The same again, in a terminal:' : 'In a terminal:'), commandLine(command));
}

// Return {text, kind, hints, checks, notes} of a grading that has ended; without a result, it broke off.
export function verdictOf({result}) {
  if (!result) return {text: 'no verdict', kind: 'bad', hints: [], checks: [], notes: []};
  const {outcome, score, objections, hints, certain, notes, reasons, seconds, isolation} = result;
  const points = outcome === 'undecided' ? '' : `, ${number(score)} of 100`;
  const again = outcome === 'undecided' ? ['That is no fault of the program: grade it again.'] : [];
  return {
    text: `${outcome}${points}`, kind: KINDS[outcome] ?? 'busy',
    hints: [...objections, ...hints.map((hint) => `${certain ? 'Mistake' : 'Hint'}: ${hint}`), ...again],
    checks: reasons.map((reason) => ({...reason, points: number(reason.points), of: number(reason.of)})),
    notes: [...notes, `Graded ${number(seconds)} s of simulated time; isolation of the program: ${isolation || 'none'}.`],
  };
}

// Return the name of a program, and its folder as seen from one of the folders, with that one's name if there are several.
export function shortPath(path, folders) {
  const folder = folders.filter((candidate) => path.startsWith(`${candidate}/`)).sort((a, b) => b.length - a.length)[0];
  if (!folder) return path;
  const parts = path.slice(folder.length + 1).split('/');
  const name = parts.pop();
  if (folders.length > 1) parts.unshift(folder.split('/').pop());
  return parts.length ? `${name} (${parts.join('/')})` : name;
}

function number(value) {
  return String(Math.round(value * 10) / 10);
}
