// Nodes: what each publishes, subscribes to and serves, and how much it logs.
import {el, fill} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {choice, labelled, setText} from './lib/parts.js';
import {Row, RowsPanel} from './lib/rows.js';
import {isDebugNode, System} from './lib/system.js';
import {clean} from './lib/values.js';

const LEVELS = ['debug', 'info', 'warn', 'error', 'fatal'];
const LOGGER = 'rosout'; // rospy's logger of what the program itself logs; roscpp's is ros.PACKAGE

export const help = [
  'Every running node with its topics and services. Open one to see them, and to choose its log levels.',
  'In a terminal: rosnode list, rosnode info.'];

export default class NodesPanel extends RowsPanel {
  constructor(element, context) {
    super(context, 'nodes', 'name', ['No nodes yet', 'Only roscore and the server of this page are running.',
                                     'rosrun turtlesim turtlesim_node']);
    this._requested = context.parameters.node || '';
    this._debug = labelled('Also those of tools', {type: 'checkbox', checked: isDebugNode(this._requested),
                                                   on: {change: () => this.arrange()}});
    this.build(element, {tools: this._debug.element,
                         links: el('a', {class: 'button-link', href: addressOf('graph')}, 'Show as a graph')});
    new System(this.scope, context.rosapi, (system) => this._show(system), (error) => this.notice.say(error.message, true));
  }

  isUsual(name) {
    return this._debug.input.checked || !isDebugNode(name);
  }

  _show(system) {
    this.notice.say('');
    for (const [name, row] of this.rows) if (!system.nodes.has(name)) this.remove(row);
    for (const [name, details] of system.nodes) {
      if (!this.rows.has(name)) this.rows.set(name, new NodeRow(this, name));
      this.rows.get(name).update(details, system.types);
    }
    this.arrange();
    if (this.rows.has(this._requested)) {
      this.reveal(this._requested);
      this._requested = '';
    }
  }
}

class NodeRow extends Row {
  constructor(panel, name) {
    const summary = el('span', {class: 'muted small'});
    super(panel, name, summary);
    this._json = '';
    this._summary = summary;
    this._lists = el('div', {class: 'columns'});
    this._level = el('div', {});
    fill(this.body, this._lists, this._level, el('div', {class: 'row'},
      el('a', {class: 'button-link', href: addressOf('console', {node: name})}, 'What it logs'),
      el('a', {class: 'button-link', href: addressOf('graph', {filter: name})}, 'Show in the graph'),
      el('a', {class: 'button-link', href: addressOf('parameters', {filter: name})}, 'Its parameters')));
  }

  update(details, types) {
    const json = JSON.stringify(details);
    if (json === this._json) return;
    this._json = json;
    const {publishing, subscribing, services} = details;
    setText(this._summary, `${publishing.length} published, ${subscribing.length} subscribed, ${services.length} services`);
    const topic = (name) => [el('a', {href: addressOf('topics', {open: name})}, clean(name, 200)), ' ',
                             el('span', {class: 'muted small'}, clean(types.get(name) || '', 100))];
    const service = (name) => el('a', {href: addressOf('services', {service: name})}, clean(name, 200));
    fill(this._lists, list('Publishes', publishing, topic), list('Subscribes to', subscribing, topic),
         list('Serves', services, service));
    this._hasLoggers = services.includes(`${this.name}/set_logger_level`);
  }

  open() {
    this.expand(true);
    this.panel.context.setParameters({node: this.name});
    this._showLevel();
  }

  close() {
    this.expand(false);
    this.panel.context.setParameters({node: ''});
  }

  async _showLevel() {
    fill(this._level);
    if (!this._hasLoggers) return;
    const {ros, toast} = this.panel.context;
    try {
      const {loggers} = await ros.call(`${this.name}/get_loggers`);
      const logger = loggers.find(({name}) => name === LOGGER) || loggers.find(({name}) => name === 'ros') || loggers[0];
      if (!logger) return;
      const level = choice('Logs from this level on', LEVELS.map((name) => [name, name]), async () => {
        try {
          await ros.call(`${this.name}/set_logger_level`, {logger: logger.name, level: level.input.value});
          toast(`${this.name} logs ${level.input.value} and above.`);
        } catch (error) {
          toast(error.message, 'error');
        }
      });
      level.input.value = logger.level.toLowerCase();
      fill(this._level, el('div', {class: 'row'}, level.element));
    } catch (error) {
      fill(this._level, el('p', {class: 'muted small'}, `The node does not report its log levels: ${error.message}`));
    }
  }
}

function list(title, names, show) {
  return el('div', {}, el('h2', {}, `${title} (${names.length})`),
            names.length ? el('ul', {class: 'plain-list'}, [...names].sort().slice(0, 200).map((name) => el('li', {}, show(name))))
              : el('p', {class: 'muted small'}, 'nothing'));
}
