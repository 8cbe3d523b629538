// Services, called by a form made of their type.
import {commandLine, el, fill} from '../app/dom.js';
import {asArgument, labelled, Notice, Scope} from './lib/parts.js';
import {Row, RowsPanel} from './lib/rows.js';
import {Form, Invalid} from './lib/form.js';
import {serviceTypes} from './lib/types.js';
import {Tree} from './lib/tree.js';
import {clean} from './lib/values.js';

const LIST = 2; // s between two polls for services
const CALL_TIMEOUT = 600; // s for an answer: some services drive a robot somewhere
const OF_EVERY_NODE = /\/(get_loggers|set_logger_level|tf2_frames)$|^\/rosapi\//;

export const help = [
  'Every service. Open one to fill in its request and call it; the answer appears below.',
  'In a terminal: rosservice list, rosservice call.'];

export default class ServicesPanel extends RowsPanel {
  constructor(element, context) {
    super(context, 'services', 'name', ['No services yet', 'Services appear as soon as a node offers some.',
                                        'rosrun turtlesim turtlesim_node']);
    this._requested = context.parameters.service || '';
    this._all = labelled('Also those of every node', {
      type: 'checkbox', checked: OF_EVERY_NODE.test(this._requested), on: {change: () => this.arrange()}});
    this.build(element, {tools: this._all.element});
    this.scope.every(LIST, () => this._load(), (error) => this.notice.say(error.message, true));
    this.scope.add(() => this.rows.forEach((row) => row.close()));
  }

  isUsual(name, words) {
    return this._all.input.checked || words.length || !OF_EVERY_NODE.test(name);
  }

  async _load() {
    const services = new Set(await this.context.rosapi.services());
    if (this.scope.ended) return;
    this.notice.say('');
    for (const [name, row] of this.rows) {
      row.setGone(!services.has(name));
      if (!services.has(name) && !row.stays) this.remove(row);
    }
    for (const name of services) {
      if (!this.rows.has(name)) this.rows.set(name, new ServiceRow(this, name));
    }
    this.arrange();
    if (this.rows.has(this._requested)) {
      this.reveal(this._requested);
      this._requested = '';
    }
  }

  opened(name) {
    for (const row of this.rows.values()) if (row.name !== name) row.close();
    this.context.setParameters({service: name});
  }
}

class ServiceRow extends Row {
  constructor(panel, name) {
    const gone = el('span', {class: 'pill bad', hidden: true}, 'gone');
    super(panel, name, gone);
    this._scope = null;
    this._gone = gone;
  }

  setGone(gone) {
    this._gone.hidden = !gone;
  }

  close(byHand = false) {
    if (!this._scope) return;
    this._scope.end();
    this._scope = null;
    this.stays = false;
    this.expand(false);
    fill(this.body);
    if (byHand) this.panel.opened('');
  }

  async open() {
    const scope = this._scope = new Scope(this.panel.context.ros);
    this.panel.opened(this.name);
    this.stays = true;
    this.expand(true);
    fill(this.body, el('p', {class: 'muted'}, 'Asking for the type …'));
    try {
      const types = await serviceTypes(this.panel.context.ros, this.name);
      if (!scope.ended) this._showForm(scope, types);
    } catch (error) {
      if (!scope.ended) fill(this.body, el('p', {class: 'notice bad', role: 'alert'}, error.message));
    }
  }

  _showForm(scope, {type, request, response}) {
    const form = new Form(request);
    const call = el('button', {type: 'submit', class: 'primary'}, 'Call');
    const notice = new Notice();
    const answer = el('div', {});
    fill(this.body, el('p', {class: 'muted small'}, 'Type: ', el('code', {}, clean(type, 100))),
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
      const values = await this.panel.context.ros.call(this.name, request, {timeout: CALL_TIMEOUT * 1000});
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
