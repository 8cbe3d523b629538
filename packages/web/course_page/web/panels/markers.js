// Why not?: what the marker tracker makes of an image of the camera, or of a photo.
import {commandLine, el, emptyState, fill} from '../app/dom.js';
import {button, choice, labelled, Notice, Panel} from './lib/parts.js';
import {clean} from './lib/values.js';

const LIST = 2; // s between two polls for trackers
const TIMEOUT = 15000; // ms; the tracker waits for an image for 5 s
const SUFFIX = '/explained_image';
const LARGEST_FILE = 50e6; // bytes that the browser decodes
const LARGEST = 1e6; // bytes that the server takes
const SIDES = [1600, 1280, 960]; // px: the longer side of what is sent, the first one that is small enough

export const help = [
  'Why is a marker not found? Each dark quadrilateral of the image gets a number and a line: found as which marker, or the first '
    + 'thing that it lacks. The README of ar_track_alvar says what to do about it.',
  'A photo is sent to the server of this page and nowhere else; nothing is kept.',
  'In a terminal: rosservice call /ar_track_alvar/explain.'];

export default class MarkersPanel extends Panel {
  constructor(element, context) {
    super(context);
    this._requests = 0;
    this._tracker = choice('Tracker', []);
    this._ask = button('Explain the camera\'s image', () => this._explain(), {class: 'primary'});
    this._camera = el('div', {class: 'row', hidden: true}, this._tracker.element, this._ask);
    this._none = el('div', {});
    const photo = labelled('A photo of your own', {type: 'file', accept: 'image/*'});
    photo.input.addEventListener('change', () => photo.input.files.length && this._send(photo.input.files[0]));
    photo.input.addEventListener('click', () => { photo.input.value = ''; }); // the same file again
    this._notice = new Notice();
    this._picture = el('img', {alt: 'The image with the numbers of the lines below', on: {error: () => this._noPicture()}});
    this._box = el('div', {class: 'image-box', hidden: true}, this._picture);
    this._lines = el('ul', {class: 'plain-list explained'});
    this._command = el('div', {});
    element.classList.add('without-ros');
    fill(element, el('div', {class: 'toolbar'}, this._camera, photo.element), this._none, this._notice.element, this._box, this._lines,
         this._command);
    this._showTrackers([]);
    this.scope.every(LIST, () => this._list(), (error) => this._notice.say(error.message, true));
  }

  async _list() {
    const images = await this.context.rosapi.topicsOfType('sensor_msgs/Image');
    if (!this.scope.ended) this._showTrackers(images.filter((name) => name.endsWith(SUFFIX)).map((name) => name.slice(0, -SUFFIX.length)).sort());
  }

  _showTrackers(names) {
    const known = names.join('\n');
    if (known === this._known) return;
    this._known = known;
    this._camera.hidden = !names.length;
    const chosen = this._tracker.input.value;
    fill(this._tracker.input, names.map((name) => el('option', {value: name}, clean(name, 100))));
    if (names.includes(chosen)) this._tracker.input.value = chosen;
    fill(this._none, names.length ? [] : emptyState('No tracker runs', 'These commands start one with a camera; a photo needs none.',
      'roslaunch turtle_robotont camera_ar_track.launch', 'roslaunch turtle_robotont ar_control.launch'));
  }

  // Show what `work` returns, {lines, src, command}, unless something else was asked meanwhile.
  async _show(doing, work) {
    this._requests += 1;
    const number = this._requests;
    this._clear();
    this._none.hidden = true;
    this._notice.say(doing);
    try {
      const {lines: raw, src, command = ''} = await work();
      const lines = raw.map((line) => clean(line, 500));
      if (this.scope.ended || number !== this._requests) return;
      this._notice.say('');
      fill(this._lines, lines.map((line) => el('li', {}, line)));
      fill(this._command, command ? commandLine(command) : []);
      this._picture.src = src;
      this._box.hidden = false;
      this.context.announce(`${lines.length} ${lines.length === 1 ? 'line' : 'lines'}. ${lines[0]}`);
    } catch (error) {
      if (!this.scope.ended && number === this._requests) this._notice.say(error.message, true);
    }
  }

  // The server gives the next image of a topic that another panel shows, too: that has just come.
  _noPicture() {
    if (this._picture.getAttribute('src')) this._notice.say('The picture is not shown here: the panel Image shows it.', true);
  }

  _clear() {
    this._picture.removeAttribute('src');
    this._box.hidden = true;
    fill(this._lines);
    fill(this._command);
  }

  _explain() {
    const tracker = this._tracker.input.value;
    return this._show('The tracker explains its last image …', async () => {
      const {success, message} = await this.context.ros.call(`${tracker}/explain`, {}, {timeout: TIMEOUT});
      if (!success) throw new Error(message);
      const lines = message.split('\n').filter((line) => !line.startsWith('Drawn in '));
      return {lines, src: `snapshot?${new URLSearchParams({topic: tracker + SUFFIX, type: 'png', again: this._requests})}`,
              command: `rosservice call ${tracker}/explain`};
    });
  }

  _send(file) {
    return this._show('The photo is being searched …', async () => {
      const {blob, notes} = await readyToSend(file);
      const answer = await fetch('marker_photo', {method: 'POST', body: blob});
      if (!answer.ok) throw new Error(`${clean((await answer.text()).trim(), 300)}.`);
      const {lines, picture} = await answer.json();
      return {lines: [...notes, ...lines], src: `data:image/jpeg;base64,${picture}`};
    });
  }
}

// Return {blob, notes} of a file: a JPEG or PNG that the server takes, and lines about what was changed.
async function readyToSend(file) {
  if (file.size > LARGEST_FILE) {
    throw new Error(`The file has ${Math.round(file.size / 1e6)} MB; at most ${LARGEST_FILE / 1e6} are allowed. Save a smaller picture.`);
  }
  let picture = null;
  try {
    picture = await createImageBitmap(file);
  } catch {
    throw new Error('This browser cannot read that file as a picture. Save it as a JPEG or PNG, and choose that one.');
  }
  const {width, height} = picture;
  const longer = Math.max(width, height);
  if (longer <= SIDES[0] && file.size <= LARGEST && /^image\/(jpeg|png)$/.test(file.type)) return {blob: file, notes: []};
  for (const side of SIDES) {
    const scale = Math.min(1, side / longer);
    const canvas = el('canvas', {width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale))});
    const drawing = canvas.getContext('2d');
    drawing.imageSmoothingQuality = 'high';
    drawing.drawImage(picture, 0, 0, canvas.width, canvas.height);
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, 'image/jpeg', 0.92));
    if (blob && blob.size <= LARGEST) {
      const notes = scale < 1 ? [`The photo has ${width} x ${height} pixels; it was searched at ${canvas.width} x ${canvas.height}.`] : [];
      return {blob, notes};
    }
  }
  throw new Error(`The picture has ${width} x ${height} pixels and is too large to be sent. Cut out the marker and its surroundings.`);
}
