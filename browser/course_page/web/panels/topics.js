// Topics: types, rates, bandwidths, live values; publishing by a form.
import {el, emptyState, fill, styleSheet} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {button, labelled, Notice, Scope, setText, suggestions} from './lib/parts.js';
import {Monitor} from './lib/monitor.js';
import {NamespaceList} from './lib/namespaces.js';
import {showPublisher} from './lib/publisher.js';
import {Tree} from './lib/tree.js';
import {messageTypes} from './lib/types.js';
import {bytesText, clean} from './lib/values.js';

styleSheet('panels/panels.css');

const LIST = 2; // s between two polls for topics
const NODES = 3; // s between two polls for publishers and subscribers
const SHOW = 0.25; // s between two updates of what is open
const PICTURES = new Set(['sensor_msgs/Image', 'sensor_msgs/CompressedImage']);
const MOST_OPEN = 30;

export default {
  id: 'topics',
  title: 'Topics',
  help: ['Every topic with its type. Open one to see its values, rate and bandwidth, and to publish on it.',
         'Only open topics are subscribed to. In a terminal: rostopic list, rostopic echo, rostopic hz.'],
  mount(element, context) {
    const panel = new TopicsPanel(element, context);
    return () => panel.scope.end();
  },
};

class TopicsPanel {
  constructor(element, context) {
    this.context = context;
    this.scope = new Scope(context.ros);
    this._rows = new Map();
    this._types = new Map();
    this._wanted = new Set((context.parameters.open || '').split(',').filter(Boolean));
    this._filter = labelled('Filter', {type: 'search', value: context.parameters.filter || '',
                                       placeholder: 'a part of a name or type', on: {input: () => this._arrange()}});
    this._count = el('p', {class: 'muted small', role: 'status'});
    this._notice = new Notice();
    this._list = new NamespaceList('topics');
    this._empty = el('div', {});
    fill(element, el('div', {class: 'toolbar'}, this._filter.element, this._count), this._notice.element,
         this._empty, this._list.element, this._newTopic());
    this.scope.every(LIST, () => this._load(), (error) => this._notice.say(error.message, true));
    this.scope.every(SHOW, () => {
      for (const row of this._rows.values()) row.show();
    });
    this.scope.add(() => this._rows.forEach((row) => row.close()));
  }

  async _load() {
    const topics = await this.context.rosapi.topics();
    if (this.scope.ended) return;
    this._notice.say('');
    const found = new Map(topics.map(({name, type}) => [name, type]));
    for (const [name, row] of this._rows) {
      if (found.get(name) !== row.type) {
        if (row.isOpen) this._wanted.add(name); // it is opened again when it comes back
        row.close();
        row.element.remove();
        this._rows.delete(name);
      }
    }
    for (const [name, type] of found) {
      if (!this._rows.has(name)) this._rows.set(name, new TopicRow(this, name, type));
    }
    this._arrange();
    for (const name of [...this._wanted]) {
      if (!this._rows.has(name) || !this._wanted.delete(name)) continue;
      this._list.reveal(name);
      this._rows.get(name).open();
    }
    this._knownTypes([...new Set(found.values())].filter(Boolean).sort());
  }

  _arrange() {
    const words = this._filter.input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const names = [...this._rows.keys()].sort();
    let shown = 0;
    for (const name of names) {
      const row = this._rows.get(name);
      const hit = words.every((word) => `${name} ${row.type}`.toLowerCase().includes(word));
      row.element.hidden = !hit;
      shown += hit;
    }
    this._list.arrange(this._rows.values(), words.length > 0);
    setText(this._count, words.length ? `${shown} of ${names.length} topics` : `${names.length} topics`);
    if (!names.length) {
      fill(this._empty, emptyState('No topics yet', 'Topics appear as soon as a node publishes or subscribes.',
                                   'rosrun turtlesim turtlesim_node'));
    } else {
      fill(this._empty, shown ? [] : el('p', {class: 'muted'}, 'No name or type contains this. Clear the filter to see all.'));
    }
  }

  keepOpen() {
    const open = [...this._rows.values()].filter((row) => row.isOpen).map((row) => row.name);
    this.context.setParameters({open: open.join(',')});
  }

  openCount() {
    return [...this._rows.values()].filter((row) => row.isOpen).length;
  }

  _newTopic() {
    const [types, setTypes] = suggestions();
    this._knownTypes = setTypes;
    const name = labelled('Topic', {placeholder: '/turtle1/cmd_vel'});
    const type = labelled('Type', {placeholder: 'geometry_msgs/Twist', list: types.id});
    const notice = new Notice();
    const place = el('div', {class: 'stack'});
    let scope = null;
    const show = async () => {
      notice.say('');
      if (scope) scope.end();
      scope = new Scope(this.context.ros);
      this.scope.add(() => scope.end());
      fill(place);
      try {
        const topic = name.input.value.trim();
        if (!/^[/~]?[A-Za-z][\w/]*$/.test(topic)) {
          name.input.focus();
          throw new Error(`"${clean(topic, 60)}" is not a name of a topic. Use letters, digits, _ and /, as in /turtle1/cmd_vel.`);
        }
        if (!/^\w+\/\w+$/.test(type.input.value.trim())) {
          type.input.focus();
          throw new Error('The type has the form package/Name, as in geometry_msgs/Twist.');
        }
        await showPublisher(place, scope, this.context, topic, type.input.value.trim());
      } catch (error) {
        notice.say(error.message, true);
      }
    };
    return el('details', {class: 'card'}, el('summary', {}, 'Publish on a topic that is not in the list'),
              el('form', {class: 'toolbar', on: {submit: (event) => {
                event.preventDefault();
                show();
              }}}, name.element, type.element, types, el('button', {type: 'submit'}, 'Make a form')),
              notice.element, place);
  }
}

class TopicRow {
  constructor(panel, name, type) {
    this.name = name;
    this.type = type;
    this._panel = panel;
    this._scope = null;
    this._rate = el('span', {class: 'number rate'});
    this._bandwidth = el('span', {class: 'number bandwidth'});
    this._body = el('div', {class: 'row-body stack', hidden: true});
    this._button = el('button', {type: 'button', class: 'row-head', 'aria-expanded': 'false',
                                 on: {click: () => (this.isOpen ? this.close(true) : this.open(true))}},
                      el('bdi', {class: 'row-name'}, clean(name, 300)),
                      el('bdi', {class: 'muted small'}, type ? clean(type, 100) : 'type unknown'), this._rate,
                      this._bandwidth);
    this.element = el('li', {}, this._button, this._body);
  }

  get isOpen() {
    return this._scope !== null;
  }

  async open(byHand = false) {
    if (this.isOpen) return;
    if (this._panel.openCount() >= MOST_OPEN) {
      this._panel.context.toast(`${MOST_OPEN} topics are open already. Close one first.`, 'warning');
      return;
    }
    const scope = this._scope = new Scope(this._panel.context.ros);
    this._button.setAttribute('aria-expanded', 'true');
    this._body.hidden = false;
    fill(this._body, el('p', {class: 'muted'}, 'Asking for the type …'));
    if (byHand) this._panel.keepOpen();
    try {
      if (!this.type) throw new Error('The type of this topic is not known yet. It appears with the first publisher.');
      const types = await messageTypes(this._panel.context.ros, this.type);
      if (!scope.ended) this._showBody(scope, types);
    } catch (error) {
      if (!scope.ended) fill(this._body, el('p', {class: 'notice bad'}, error.message));
    }
  }

  _showBody(scope, types) {
    const {context} = this._panel;
    this._monitor = new Monitor(context.ros, this.name, this.type, types);
    scope.add(() => this._monitor.end());
    this._tree = new Tree(types, this.name);
    this._waiting = el('p', {class: 'muted'}, 'No message yet.');
    this._tree.element.hidden = true;
    const people = el('p', {class: 'small muted'});
    const publish = el('details', {class: 'inner', on: {toggle: () => {
      if (publish.open && !place.firstChild) {
        showPublisher(place, scope, context, this.name, this.type).catch((error) => fill(place, error.message));
      }
    }}}, el('summary', {}, 'Publish on this topic'));
    const place = el('div', {class: 'stack'});
    publish.append(place);
    const numbers = types.numericPaths();
    fill(this._body, this._waiting, this._tree.element, people, el('div', {class: 'row'},
      numbers.length ? el('a', {class: 'button-link', href: addressOf('plot', {
        fields: numbers.slice(0, 6).map((path) => `${this.name}/${path}`).join(',')})}, 'Plot its numbers') : null,
      PICTURES.has(this.type)
        ? el('a', {class: 'button-link', href: addressOf('image', {topic: this.name})}, 'Show as a picture') : null),
    publish);
    scope.every(NODES, async () => {
      const [publishers, subscribers] = await Promise.all([
        context.rosapi.publishers(this.name), context.rosapi.subscribers(this.name)]);
      setText(people, `Publishers: ${names(publishers)}. Subscribers: ${names(subscribers)}.`);
      setText(this._waiting, publishers.length ? 'No message yet.' : 'No message yet: no node publishes on this topic.');
    }, () => {});
  }

  show() {
    if (!this._monitor) return;
    const found = this._monitor.read();
    setText(this._rate, found ? `${this._monitor.partial ? '≥ ' : ''}${found.rate.toFixed(found.rate < 10 ? 2 : 1)} Hz` : '');
    setText(this._bandwidth, found ? `${bytesText(found.bandwidth)}/s` : '');
    if (this._monitor.message !== undefined && this._monitor.count !== this._shown) {
      this._shown = this._monitor.count;
      this._waiting.hidden = true;
      this._tree.element.hidden = false;
      this._tree.update(this._monitor.message);
    }
  }

  close(byHand = false) {
    if (!this.isOpen) return;
    this._scope.end();
    this._scope = this._monitor = null;
    this._button.setAttribute('aria-expanded', 'false');
    this._body.hidden = true;
    fill(this._body);
    setText(this._rate, '');
    setText(this._bandwidth, '');
    if (byHand) this._panel.keepOpen();
  }
}

function names(list) {
  return list.length ? list.slice(0, 10).map((name) => clean(name, 80)).join(', ')
    + (list.length > 10 ? ` and ${list.length - 10} more` : '') : 'none';
}
