// Services, called by a form made of their type.
import {commandLine, el, emptyState, fill, styleSheet} from '../app/dom.js';
import {asArgument, labelled, Notice, Scope, setText} from './lib/parts.js';
import {NamespaceList} from './lib/namespaces.js';
import {Form, Invalid} from './lib/form.js';
import {serviceTypes} from './lib/types.js';
import {Tree} from './lib/tree.js';
import {clean} from './lib/values.js';

styleSheet('panels/panels.css');

const LIST = 2; // s between two polls for services
const CALL_TIMEOUT = 600; // s for an answer: some services drive a robot somewhere
const OF_EVERY_NODE = /\/(get_loggers|set_logger_level|tf2_frames)$|^\/rosapi\//;

export default {
  id: 'services',
  title: 'Services',
  help: ['Every service. Open one to fill in its request and call it; the answer appears below.',
         'In a terminal: rosservice list, rosservice call.'],
  mount(element, context) {
    const panel = new ServicesPanel(element, context);
    return () => panel.scope.end();
  },
};

class ServicesPanel {
  constructor(element, context) {
    this.context = context;
    this.scope = new Scope(context.ros);
    this._rows = new Map();
    this._wanted = context.parameters.service || '';
    this._filter = labelled('Filter', {type: 'search', placeholder: 'a part of a name', on: {input: () => this._arrange()}});
    this._all = labelled('Also those of every node', {
      type: 'checkbox', checked: OF_EVERY_NODE.test(this._wanted), on: {change: () => this._arrange()}});
    this._count = el('p', {class: 'muted small', role: 'status'});
    this._notice = new Notice();
    this._empty = el('div', {});
    this._list = new NamespaceList('services');
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, this._all.element, this._count),
         this._notice.element, this._empty, this._list.element);
    this.scope.every(LIST, () => this._load(), (error) => this._notice.say(error.message, true));
    this.scope.add(() => this._rows.forEach((row) => row.close()));
  }

  async _load() {
    const services = new Set(await this.context.rosapi.services());
    if (this.scope.ended) return;
    this._notice.say('');
    for (const [name, row] of this._rows) {
      row.setGone(!services.has(name));
      if (!services.has(name) && !row.isOpen) {
        row.element.remove();
        this._rows.delete(name);
      }
    }
    for (const name of services) {
      if (!this._rows.has(name)) this._rows.set(name, new ServiceRow(this, name));
    }
    this._arrange();
    if (this._rows.has(this._wanted)) {
      this._list.reveal(this._wanted);
      this._rows.get(this._wanted).open();
      this._wanted = '';
    }
  }

  _arrange() {
    const words = this._filter.input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const names = [...this._rows.keys()].filter((name) => (
      this._all.input.checked || words.length || !OF_EVERY_NODE.test(name))).sort();
    const shown = new Set(names.filter((name) => words.every((word) => name.toLowerCase().includes(word))));
    for (const [name, row] of this._rows) {
      row.element.hidden = !shown.has(name) && !row.isOpen;
    }
    this._list.arrange(this._rows.values(), words.length > 0);
    setText(this._count, words.length ? `${shown.size} of ${names.length} services` : `${names.length} services`);
    if (!names.length) {
      fill(this._empty, emptyState('No services yet', 'Services appear as soon as a node offers some.',
                                   'rosrun turtlesim turtlesim_node'));
    } else {
      fill(this._empty, shown.size ? [] : el('p', {class: 'muted'}, 'No name contains this. Clear the filter to see all.'));
    }
  }

  opened(name) {
    for (const row of this._rows.values()) if (row.name !== name) row.close();
    this.context.setParameters({service: name});
  }
}

class ServiceRow {
  constructor(panel, name) {
    this.name = name;
    this._panel = panel;
    this._scope = null;
    this._gone = el('span', {class: 'pill bad', hidden: true}, 'gone');
    this._body = el('div', {class: 'row-body stack', hidden: true});
    this._button = el('button', {type: 'button', class: 'row-head', 'aria-expanded': 'false', on: {click: () => {
      if (!this.isOpen) {
        this.open();
      } else {
        this.close();
        panel.opened('');
      }
    }}}, el('bdi', {class: 'row-name'}, clean(name, 300)), this._gone);
    this.element = el('li', {}, this._button, this._body);
  }

  get isOpen() {
    return this._scope !== null;
  }

  setGone(gone) {
    this._gone.hidden = !gone;
  }

  close() {
    if (!this.isOpen) return;
    this._scope.end();
    this._scope = null;
    this._button.setAttribute('aria-expanded', 'false');
    this._body.hidden = true;
    fill(this._body);
  }

  async open() {
    const scope = this._scope = new Scope(this._panel.context.ros);
    this._panel.opened(this.name);
    this._button.setAttribute('aria-expanded', 'true');
    this._body.hidden = false;
    fill(this._body, el('p', {class: 'muted'}, 'Asking for the type …'));
    try {
      const types = await serviceTypes(this._panel.context.ros, this.name);
      if (!scope.ended) this._showForm(scope, types);
    } catch (error) {
      if (!scope.ended) fill(this._body, el('p', {class: 'notice bad', role: 'alert'}, error.message));
    }
  }

  _showForm(scope, {type, request, response}) {
    const form = new Form(request);
    const call = el('button', {type: 'submit', class: 'primary'}, 'Call');
    const notice = new Notice();
    const answer = el('div', {});
    fill(this._body, el('p', {class: 'muted small'}, 'Type: ', el('code', {}, clean(type, 100))),
         el('form', {class: 'stack', noValidate: true, on: {submit: (event) => {
           event.preventDefault();
           this._call(scope, form, response, call, notice, answer);
         }}}, form.element, el('div', {}, call)), notice.element, answer);
  }

  async _call(scope, form, response, call, notice, answer) {
    let request;
    fill(answer);
    try {
      request = form.read();
    } catch (error) {
      if (!(error instanceof Invalid)) throw error;
      notice.say(error.message, true);
      return;
    }
    const command = [el('p', {class: 'muted small'}, 'The same in a terminal:'),
                     commandLine(`rosservice call ${this.name} ${asArgument(request)}`)];
    const start = performance.now();
    const passed = () => ((performance.now() - start) / 1000);
    const clock = setInterval(() => notice.say(`Waiting for the answer: ${passed().toFixed(0)} s`), 1000);
    const stop = scope.add(() => clearInterval(clock));
    call.disabled = true;
    notice.say('Calling …');
    try {
      const values = await this._panel.context.ros.call(this.name, request, {timeout: CALL_TIMEOUT * 1000});
      if (scope.ended) return;
      notice.say(`Answered in ${passed().toFixed(3)} s.`);
      const tree = new Tree(response);
      tree.update(values);
      tree.element.querySelectorAll('details').forEach((branch) => { branch.open = true; });
      fill(answer, response.fieldsOf().length ? tree.element : el('p', {}, 'The answer is empty, as it is for this service.'),
           command);
    } catch (error) {
      if (scope.ended) return;
      notice.say(`The call failed: ${clean(error.message, 1000)}`, true);
      fill(answer, command);
    } finally {
      stop();
      call.disabled = false;
      if (!scope.ended) call.focus();
    }
  }
}
