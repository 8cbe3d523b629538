// Topics: types, rates, bandwidths, live values; publishing by a form.
import {el, fill} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {labelled, Notice, Scope, setText, suggestions} from './lib/parts.js';
import {Monitor} from './lib/monitor.js';
import {showPublisher} from './lib/publisher.js';
import {Row, RowsPanel} from './lib/rows.js';
import {Tree} from './lib/tree.js';
import {messageTypes} from './lib/types.js';
import {bytesText, clean} from './lib/values.js';

const LIST = 2; // s between two polls for topics
const NODES = 3; // s between two polls for publishers and subscribers
const SHOW = 0.25; // s between two updates of what is open
const PICTURES = new Set(['sensor_msgs/Image', 'sensor_msgs/CompressedImage']);
const MOST_OPEN = 30;

export const help = [
  'Every topic with its type. Open one to see its values, rate and bandwidth, and to publish on it.',
  'Only open topics are subscribed to. In a terminal: rostopic list, rostopic echo, rostopic hz.'];

export default class TopicsPanel extends RowsPanel {
  constructor(element, context) {
    super(context, 'topics', 'name or type', ['No topics yet', 'Topics appear as soon as a node publishes or subscribes.',
                                              'rosrun turtlesim turtlesim_node']);
    this._wanted = new Set((context.parameters.open || '').split(',').filter(Boolean));
    this.build(element, {after: this._newTopic()});
    this.scope.every(LIST, () => this._load(), (error) => this.notice.say(error.message, true));
    this.scope.every(SHOW, () => {
      for (const row of this.rows.values()) row.show();
    });
    this.scope.add(() => this.rows.forEach((row) => row.close()));
  }

  async _load() {
    const topics = await this.context.rosapi.topics();
    if (this.scope.ended) return;
    this.notice.say('');
    const found = new Map(topics.map(({name, type}) => [name, type]));
    for (const [name, row] of this.rows) {
      if (found.get(name) !== row.type) {
        if (row.isOpen) this._wanted.add(name); // it is opened again when it comes back
        row.close();
        this.remove(row);
      }
    }
    for (const [name, type] of found) {
      if (!this.rows.has(name)) this.rows.set(name, new TopicRow(this, name, type));
    }
    this.arrange();
    for (const name of [...this._wanted]) if (this.rows.has(name) && this._wanted.delete(name)) this.reveal(name);
    this._knownTypes([...new Set(found.values())].filter(Boolean).sort());
  }

  keepOpen() {
    this.context.setParameters({open: this.opened.map((row) => row.name).join(',')});
  }

  get opened() {
    return [...this.rows.values()].filter((row) => row.isOpen);
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

class TopicRow extends Row {
  constructor(panel, name, type) {
    const [rate, bandwidth] = ['rate', 'bandwidth'].map((kind) => el('span', {class: `number ${kind}`}));
    super(panel, name, el('bdi', {class: 'muted small'}, type ? clean(type, 100) : 'type unknown'), rate, bandwidth);
    this.type = type;
    this.searched = `${name} ${type}`;
    this._scope = null;
    this._rate = rate;
    this._bandwidth = bandwidth;
  }

  get isOpen() {
    return this._scope !== null;
  }

  async open(byHand = false) {
    if (this.isOpen) return;
    if (this.panel.opened.length >= MOST_OPEN) {
      this.panel.context.toast(`${MOST_OPEN} topics are open already. Close one first.`, 'warning');
      return;
    }
    const scope = this._scope = new Scope(this.panel.context.ros);
    this.expand(true);
    fill(this.body, el('p', {class: 'muted'}, 'Asking for the type …'));
    if (byHand) this.panel.keepOpen();
    try {
      if (!this.type) throw new Error('The type of this topic is not known yet. It appears with the first publisher.');
      const types = await messageTypes(this.panel.context.ros, this.type);
      if (!scope.ended) this._showBody(scope, types);
    } catch (error) {
      if (!scope.ended) fill(this.body, el('p', {class: 'notice bad'}, error.message));
    }
  }

  _showBody(scope, types) {
    const {context} = this.panel;
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
    fill(this.body, this._waiting, this._tree.element, people, el('div', {class: 'row'},
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
    this.expand(false);
    fill(this.body);
    setText(this._rate, '');
    setText(this._bandwidth, '');
    if (byHand) this.panel.keepOpen();
  }
}

function names(list) {
  return list.length ? list.slice(0, 10).map((name) => clean(name, 80)).join(', ')
    + (list.length > 10 ? ` and ${list.length - 10} more` : '') : 'none';
}
