// Topics: types, rates, bandwidths, live values; publishing by a form.
import {commandLine, el, fill} from '../app/dom.js';
import {addressOf} from '../app/address.js';
import {asArgument, button, labelled, Notice, Scope, setText, suggestions} from './lib/parts.js';
import {Row, RowsPanel} from './lib/rows.js';
import {Tree} from './lib/tree.js';
import {messageTypes} from './lib/types.js';
import {bytesText, clean, sizeOf} from './lib/values.js';
import {Form, Invalid} from './lib/form.js';

const LIST = 2; // s between two polls for topics
const NODES = 3; // s between two polls for publishers and subscribers
const SHOW = 0.25; // s between two updates of what is open
const PICTURES = new Set(['sensor_msgs/Image', 'sensor_msgs/CompressedImage']);
const MOST_OPEN = 30;
const RATE_WINDOW = 3; // s in which a rate is measured
const LIGHT = 20000; // bytes: larger messages are not all fetched
const SAMPLE_RATE = 2; // Hz, for topics with large messages
const MAX_RATE = 100; // Hz of publishing repeatedly
const VELOCITY = 'geometry_msgs/Twist';
const ZERO = {linear: {x: 0, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}};

export const help = [
  'Every topic with its type. Open one to see its values, rate and bandwidth, and to publish on it.',
  'Only open topics are subscribed to. In a terminal: rostopic list, rostopic echo, rostopic hz.'];

export default class TopicsPanel extends RowsPanel {
  constructor(element, context) {
    super(context, 'topics', 'name or type', ['No topics yet', 'Topics appear as soon as a node publishes or subscribes.',
                                              'rosrun turtlesim turtlesim_node']);
    this._requested = new Set((context.parameters.open || '').split(',').filter(Boolean));
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
        if (row.isOpen) this._requested.add(name); // it is opened again when it comes back
        row.close();
        this.remove(row);
      }
    }
    for (const [name, type] of found) {
      if (!this.rows.has(name)) this.rows.set(name, new TopicRow(this, name, type));
    }
    this.arrange();
    for (const name of [...this._requested]) if (this.rows.has(name) && this._requested.delete(name)) this.reveal(name);
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
    const container = el('div', {class: 'stack'});
    let scope = null;
    const show = async () => {
      notice.say('');
      if (scope) scope.end();
      scope = new Scope(this.context.ros);
      this.scope.add(() => scope.end());
      fill(container);
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
        await showPublisher(container, scope, this.context, topic, type.input.value.trim());
      } catch (error) {
        notice.say(error.message, true);
      }
    };
    return el('details', {class: 'card'}, el('summary', {}, 'Publish on a topic that is not in the list'),
              el('form', {class: 'toolbar', on: {submit: (event) => {
                event.preventDefault();
                show();
              }}}, name.element, type.element, types, el('button', {type: 'submit'}, 'Make a form')),
              notice.element, container);
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
      if (publish.open && !container.firstChild) {
        showPublisher(container, scope, context, this.name, this.type).catch((error) => fill(container, error.message));
      }
    }}}, el('summary', {}, 'Publish on this topic'));
    const container = el('div', {class: 'stack'});
    publish.append(container);
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

// Counts messages and bytes; times are in seconds.
export class Meter {
  constructor() {
    this._marks = []; // [time, messages, bytes]
  }

  add(time, bytes, messages = 1) {
    this._marks.push([time, messages, bytes * messages]);
    while (this._marks.length > 2 && this._marks[1][0] < time - RATE_WINDOW) this._marks.shift();
  }

  // Return {rate, bandwidth} at a time; null for each while there are too few messages.
  read(now) {
    const marks = this._marks;
    if (marks.length < 2) return null;
    const first = marks[0];
    const last = marks[marks.length - 1];
    const span = Math.max(last[0] - first[0], 1e-3);
    const between = span / (marks.length - 1);
    if (now - last[0] > Math.max(RATE_WINDOW, 3 * between)) return {rate: 0, bandwidth: 0};
    let messages = 0;
    let bytes = 0;
    for (let i = 1; i < marks.length; i += 1) {
      messages += marks[i][1];
      bytes += marks[i][2];
    }
    return {rate: messages / span, bandwidth: bytes / span};
  }
}

// Subscribes to a topic until `end()`. Of large messages only some are fetched; the sequence numbers in their headers
// then tell how many there were.
class Monitor {
  constructor(ros, topic, type, types) {
    this.message = undefined;
    this.count = 0;
    this.size = 0; // bytes of the last message
    this.partial = false; // whether the rate may be higher than shown
    this._ros = ros;
    this._topic = topic;
    this._type = type;
    this._types = types;
    this._meter = new Meter();
    this._sequence = null;
    this._light = false;
    this._end = this._subscribe(SAMPLE_RATE);
  }

  read() {
    return this._meter.read(performance.now() / 1000);
  }

  end() {
    this._end();
  }

  _subscribe(rate) {
    return this._ros.subscribe(this._topic, this._type, (message) => this._received(message), {rate});
  }

  _received(message) {
    this.message = message;
    this.count += 1;
    this.size = sizeOf(message, this._types.root, null, this._types);
    if (!this._light && this.size <= LIGHT) {
      this._light = true;
      const end = this._end;
      this._end = this._subscribe(0);
      end();
      return;
    }
    this._meter.add(performance.now() / 1000, this.size, this._light ? 1 : this._skipped(message));
  }

  // Return how many messages have been published since the last received one.
  _skipped(message) {
    const sequence = message.header ? message.header.seq : undefined;
    const before = this._sequence;
    this._sequence = sequence;
    this.partial = !(sequence > before);
    return before !== null && sequence > before && sequence - before < 10000 ? sequence - before : 1;
  }
}

// Fill `container` with a form that publishes on a topic, until the scope ends. A vehicle is stopped at the end.
async function showPublisher(container, scope, context, topic, type) {
  const types = await messageTypes(context.ros, type);
  if (scope.ended) return;
  const form = new Form(types);
  const notice = new Notice();
  const command = el('div', {});
  const rate = labelled('Times a second', {value: '10', inputmode: 'decimal', size: 5});
  let timer = null;
  let sent = 0;

  const send = () => {
    const message = form.read();
    if (!context.ros.publish(topic, type, message)) throw new Invalid('There is no connection to ROS.');
    sent += 1;
    return message;
  };
  const attempt = (work) => {
    try {
      work();
    } catch (error) {
      stop();
      if (!(error instanceof Invalid)) throw error;
      notice.say(error.message, true);
    }
  };
  const stop = () => {
    if (timer === null) return;
    clearInterval(timer);
    timer = null;
    if (type === VELOCITY) context.ros.publish(topic, type, ZERO);
    repeat.textContent = 'Publish repeatedly';
    repeat.setAttribute('aria-pressed', 'false');
    notice.say(type === VELOCITY ? `Stopped after ${sent} messages, with a velocity of zero.`
      : `Stopped after ${sent} messages.`);
  };
  const showCommand = (message, option) => fill(command,
    el('p', {class: 'muted small'}, 'The same in a terminal:'),
    commandLine(`rostopic pub ${option} ${topic} ${type} ${asArgument(message)}`));
  const once = button('Publish once', () => attempt(() => {
    showCommand(send(), '-1');
    notice.say(sent === 1 ? 'Published.' : `Published, ${sent} messages by now.`);
  }), {class: 'primary'});
  const repeat = button('Publish repeatedly', () => {
    if (timer !== null) {
      stop();
      return;
    }
    attempt(() => {
      const hertz = Number(rate.input.value.replace(',', '.'));
      if (!(hertz > 0 && hertz <= MAX_RATE)) {
        rate.input.focus();
        throw new Invalid(`"${rate.input.value}" times a second is not possible; allowed is more than 0, up to ${MAX_RATE}.`);
      }
      sent = 0;
      showCommand(send(), `-r ${hertz}`);
      timer = setInterval(() => attempt(() => {
        send();
        notice.say(`Publishing: ${sent} ${sent === 1 ? 'message' : 'messages'}.`);
      }), 1000 / hertz);
      repeat.textContent = 'Stop';
    });
  }, {'aria-pressed': 'false'});
  scope.add(stop);
  scope.listen(document, 'visibilitychange', () => document.hidden && stop());
  notice.element.setAttribute('aria-live', 'off'); // it counts
  fill(container, form.element, el('div', {class: 'toolbar'}, once, repeat, rate.element), notice.element, command);
}
