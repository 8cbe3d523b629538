// Publishing with a form, once or repeatedly.
import {commandLine, el, fill} from '../../app/dom.js';
import {asArgument, button, labelled, Notice} from './parts.js';
import {Form, Invalid} from './form.js';
import {messageTypes} from './types.js';

const MAX_RATE = 100; // Hz
const VELOCITY = 'geometry_msgs/Twist';
const ZERO = {linear: {x: 0, y: 0, z: 0}, angular: {x: 0, y: 0, z: 0}};

// Fill `place` with a form that publishes on a topic, until the scope ends. A vehicle is stopped at the end.
export async function showPublisher(place, scope, context, topic, type) {
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
  fill(place, form.element, el('div', {class: 'toolbar'}, once, repeat, rate.element), notice.element, command);
}
