// Nodes: what each publishes, subscribes to and serves, and how much it logs.
import {el, emptyState, fill, styleSheet} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {choice, labelled, Notice, Scope, setText} from './lib/parts.js';
import {NamespaceList} from './lib/namespaces.js';
import {isDebugNode, System} from './lib/system.js';
import {clean} from './lib/values.js';

styleSheet('panels/panels.css');

const LEVELS = ['debug', 'info', 'warn', 'error', 'fatal'];
const LOGGER = 'rosout'; // rospy's logger of what the program itself logs; roscpp's is ros.PACKAGE

export default {
  id: 'nodes',
  title: 'Nodes',
  help: ['Every running node with its topics and services. Open one to see them, and to choose its log levels.',
         'In a terminal: rosnode list, rosnode info.'],
  mount(element, context) {
    const panel = new NodesPanel(element, context);
    return () => panel.scope.end();
  },
};

class NodesPanel {
  constructor(element, context) {
    this.context = context;
    this.scope = new Scope(context.ros);
    this._rows = new Map();
    this._wanted = context.parameters.node || '';
    this._filter = labelled('Filter', {type: 'search', placeholder: 'a part of a name', on: {input: () => this._arrange()}});
    this._debug = labelled('Also those of tools', {type: 'checkbox', checked: isDebugNode(this._wanted),
                                                   on: {change: () => this._arrange()}});
    this._count = el('p', {class: 'muted small', role: 'status'});
    this._notice = new Notice();
    this._empty = el('div', {});
    this._list = new NamespaceList('nodes');
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, this._debug.element, this._count,
                     el('a', {class: 'button-link', href: addressOf('graph')}, 'Show as a graph')),
         this._notice.element, this._empty, this._list.element);
    new System(this.scope, context.rosapi, (system) => this._show(system), (error) => this._notice.say(error.message, true));
  }

  _show(system) {
    this._notice.say('');
    for (const [name, row] of this._rows) {
      if (!system.nodes.has(name)) {
        row.element.remove();
        this._rows.delete(name);
      }
    }
    for (const [name, details] of system.nodes) {
      if (!this._rows.has(name)) this._rows.set(name, new NodeRow(this, name));
      this._rows.get(name).update(details, system.types);
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
    const names = [...this._rows.keys()].sort();
    const usual = names.filter((name) => this._debug.input.checked || !isDebugNode(name));
    let shown = 0;
    for (const name of names) {
      const {element} = this._rows.get(name);
      element.hidden = !usual.includes(name) || !words.every((word) => name.toLowerCase().includes(word));
      shown += !element.hidden;
    }
    this._list.arrange(this._rows.values(), words.length > 0);
    setText(this._count, words.length ? `${shown} of ${usual.length} nodes` : `${usual.length} nodes`);
    if (!usual.length) {
      fill(this._empty, emptyState('No nodes yet', 'Only roscore and the server of this page are running.',
                                   'rosrun turtlesim turtlesim_node'));
    } else {
      fill(this._empty, shown ? [] : el('p', {class: 'muted'}, 'No name contains this. Clear the filter to see all.'));
    }
  }
}

class NodeRow {
  constructor(panel, name) {
    this.name = name;
    this._panel = panel;
    this._json = '';
    this._summary = el('span', {class: 'muted small'});
    this._lists = el('div', {class: 'columns'});
    this._level = el('div', {});
    this._body = el('div', {class: 'row-body stack', hidden: true}, this._lists, this._level, el('div', {class: 'row'},
      el('a', {class: 'button-link', href: addressOf('console', {node: name})}, 'What it logs'),
      el('a', {class: 'button-link', href: addressOf('graph', {filter: name})}, 'Show in the graph'),
      el('a', {class: 'button-link', href: addressOf('parameters', {filter: name})}, 'Its parameters')));
    this._button = el('button', {type: 'button', class: 'row-head', 'aria-expanded': 'false',
                                 on: {click: () => (this._body.hidden ? this.open() : this._close())}},
                      el('bdi', {class: 'row-name'}, clean(name, 300)), this._summary);
    this.element = el('li', {}, this._button, this._body);
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
    this._body.hidden = false;
    this._button.setAttribute('aria-expanded', 'true');
    this._panel.context.setParameters({node: this.name});
    this._showLevel();
  }

  _close() {
    this._body.hidden = true;
    this._button.setAttribute('aria-expanded', 'false');
    this._panel.context.setParameters({node: ''});
  }

  async _showLevel() {
    fill(this._level);
    if (!this._hasLoggers) return;
    const {ros, toast} = this._panel.context;
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
  return el('div', {}, el('h3', {}, `${title} (${names.length})`),
            names.length ? el('ul', {class: 'plain-list'}, [...names].sort().slice(0, 200).map((name) => el('li', {}, show(name))))
              : el('p', {class: 'muted small'}, 'nothing'));
}
