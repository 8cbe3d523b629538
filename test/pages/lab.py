"""The terminals, the editor and the page of ./run view --terminal in a browser, for a reader who has nothing else.

The first line of each terminal is typed on the keyboard. The others, and keys, take the WebSocket of the same terminal,
whose tab shows them. PANELS has what the page must show instead of a window.
"""
import base64
import contextlib
import json
import os
import re
import signal
import subprocess
import time

import cv2
import numpy as np
import pictures
from terminal import ANSI, POLL, Terminal, TerminalError

from rostest_support.browser import Browser

ADDRESS = re.compile(r'Open (http://\S+) in a browser')
START = 400.0  # [s] until JupyterLab is shown, on a loaded machine
SIZE = 1600, 1000  # [px]
TITLE = 'Turtle and Robotont'
OPEN_TERMINAL = '''(async () => {
    const {commands, serviceManager} = jupyterapp;
    const widget = await commands.execute("terminal:create-new");
    const {name} = widget.content.session, {wsUrl, token} = serviceManager.serverSettings;
    const socket = new WebSocket(`${wsUrl}terminals/websocket/${name}?token=${token}`);
    const kept = {text: "", socket, widget};
    socket.onmessage = ({data}) => {
        const [type, text] = JSON.parse(data);
        if (type === "stdout") kept.text += text;
    };
    await new Promise((resolve, reject) => { socket.onopen = resolve; socket.onerror = reject; });
    (window.terminals ??= {})[name] = kept;
    return name;
})()'''
FOCUS = '''(() => {
    const {widget} = terminals[%s];
    jupyterapp.shell.activateById(widget.id);
    widget.node.querySelector(".xterm-helper-textarea").focus();
})()'''
SEND = 'terminals[%s].socket.send(JSON.stringify(["stdin", %s]))'
RECEIVED = '''(() => {
    const kept = terminals[%s], {text} = kept;
    kept.text = "";
    return text;
})()'''
WRITE = '''(async () => {
    const {commands, serviceManager} = jupyterapp, path = %s;
    await serviceManager.contents.save(path, {type: "file", format: "text", content: %s});
    const widget = await commands.execute("docmanager:open", {path, factory: "Editor"});
    await widget.context.ready;
    await widget.context.revert();
})()'''
SHOW_PAGE = '''(async () => {
    const {shell} = jupyterapp, before = new Set(shell.widgets("main"));
    document.querySelector('.jp-LauncherCard[title*="TITLE"]').click();
    const wait = (ms) => new Promise((done) => setTimeout(done, ms));
    for (let tries = 0; tries < 100; tries += 1) {
        window.page = [...shell.widgets("main")].find((one) => !before.has(one));
        if (window.page) return true;
        await wait(100);
    }
    return false;
})()'''.replace('TITLE', TITLE)
OPEN_PANEL = '''(() => {
    jupyterapp.shell.activateById(page.id);
    page.node.querySelector("iframe").contentWindow.location.hash = %s;
})()'''
IN_PAGE = '(() => {const {document} = page.node.querySelector("iframe").contentWindow; return %s;})()'
CANVAS = 'document.querySelector("canvas.strokes")?.toDataURL() ?? ""'
LOOK_TIME = 60.0  # [s] for a panel to show something
SHOWS_IMAGE = 'document.querySelector("%s img")?.naturalWidth > 0'
SHOWS_TEXT = 'document.querySelector("main").innerText.includes("%s")'
SHOWS_NODES = '''(() => {
    const drawn = [...document.querySelectorAll(".graph title")].map((one) => one.textContent);
    return ["/publish_circle", "/turtlesim", "/turtle1/cmd_vel"].every((name) => drawn.includes(name));
})()'''
SHOWS_PLACE = 'document.querySelector(".map canvas") && parseFloat(document.querySelector(".pose dd").textContent) > -2'
PANELS = (  # a part of a command that runs; the panel instead of a window, and what must then be seen there
    ('turtlesim turtlesim_node', 'turtle', SHOWS_TEXT % '5.54'),
    ('topic_demo publish_circle.py', 'graph', SHOWS_NODES),                      # rqt_graph
    ('topic_demo print_poses.py', 'console', SHOWS_TEXT % 'x: 7.5'),           # rqt_console
    ('camera_ar_track.launch', 'image', SHOWS_IMAGE % '.image-box'),             # rqt_image_view
    ('topic_demo robot_forward.py', 'robot', SHOWS_PLACE),                       # Gazebo
    ('world_minimaze_ar.launch', 'robot', SHOWS_IMAGE % '.camera'))              # rviz: what the tracker finds


class Lab:
    """JupyterLab in a Chromium, started by ``./run view --terminal`` with the files of ``home``."""

    def __init__(self, repository, home, environment, folder):
        (home / '.bashrc').write_text("PS1='page$ '\n", encoding='utf-8')
        self._home, self._folder, self._seen = home, folder, set()
        self._log = open(folder / 'lab.txt', 'w+', encoding='utf-8')
        self._server = subprocess.Popen(
            [str(repository / 'run'), 'view', '--terminal', '--folder', str(home), '--port=8888', '--no-browser',
             '--expose-app-in-browser'], env=environment, cwd=home, stdout=self._log, stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL, start_new_session=True)
        self.browser = None
        try:
            self.browser = Browser(*SIZE, folder=str(folder))
            self.browser.get(self._address())
            self.browser.until(lambda: self.browser.evaluate('!!window.jupyterapp'), 'JupyterLab', START)
            self.browser.until(lambda: self.browser.find('.jp-LauncherCard'), 'the launcher', START)
            self.browser.until(lambda: self.browser.evaluate(SHOW_PAGE), 'the page in a tab', START)
        except BaseException:
            self.close()
            raise

    def terminal(self, folder, in_workspace):
        """Return a new terminal in ``folder``; each is a ./run shell."""
        return LabTerminal(self, folder)

    def look(self, commands):
        """Look at the panels that take the place of the windows of these commands, and save what the browser shows."""
        for panel in PANELS:
            part, name, shows = panel
            if panel not in self._seen and any(part in command for command in commands):
                self._seen.add(panel)
                self._wait_for(name, lambda shows=shows: self.browser.evaluate(IN_PAGE % shows), f'{name}: {part}')
                print(f'the panel {name} shows {part}', flush=True)
        self.browser.screenshot(f'browser_{len(list(self._folder.glob("*.png"))):03}')

    def compare(self, drawn):
        """Compare the picture of turtlesim with the canvas of the page."""
        picture = cv2.imread(str(drawn))
        self._wait_for('turtle', lambda: not pictures.differences_of_canvas(picture, self._canvas()), drawn.name)
        print(f'the canvas shows {drawn.name}', flush=True)

    def _canvas(self):
        data = self.browser.evaluate(IN_PAGE % CANVAS).partition(',')[2]
        if not data:
            return np.zeros((1, 1, 3), np.uint8)
        return cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)

    def _wait_for(self, panel, shows, what):
        """Open a panel of the page; wait until ``shows()``."""
        self.browser.evaluate(OPEN_PANEL % json.dumps(f'#/{panel}'))
        try:
            self.browser.until(shows, what, LOOK_TIME)
        except AssertionError as error:
            self.browser.screenshot('missing')
            raise TerminalError(f'the page does not show {what}: {error}') from error

    def unseen(self):
        """Return those of PANELS whose commands did not run."""
        return [part for part, *_ in PANELS if part not in {seen[0] for seen in self._seen}]

    def _address(self):
        end = time.monotonic() + START
        while True:
            self._log.seek(0)
            said = self._log.read()
            found = ADDRESS.search(said)
            if found:
                return found.group(1)
            if self._server.poll() is not None or time.monotonic() > end:
                raise TerminalError(f'JupyterLab does not start:\n{said}')
            time.sleep(POLL)

    def write(self, path, text):
        """Save a file below the home folder, and show it in the editor of the browser."""
        name = str(path.relative_to(self._home))
        self.browser.evaluate(WRITE % (json.dumps(name), json.dumps(text)))
        if path.read_text(encoding='utf-8') != text:
            raise TerminalError(f'JupyterLab has saved another text as {path}')

    def close(self):
        """End browser and server."""
        if self.browser is not None:
            self.browser.close()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._server.pid, signal.SIGINT)
        try:
            self._server.wait(30.0)
        except subprocess.TimeoutExpired:
            os.killpg(self._server.pid, signal.SIGKILL)
            self._server.wait()
        self._log.close()


class LabTerminal(Terminal):
    """A terminal of JupyterLab, in ``folder``."""

    def __init__(self, lab, folder):
        self._lab, self._raw, self._shown = lab, '', ''
        self._name = json.dumps(lab.browser.evaluate(OPEN_TERMINAL))
        self._begin()
        self.wait_free(START)
        lab.browser.evaluate(FOCUS % self._name)
        lab.browser.driver.switch_to.active_element.send_keys(f'cd {folder}\n')
        lab.browser.until(lambda: f'cd {folder}\n' in self._output, 'the typed line', START)
        self.wait_free(START)

    @property
    def _output(self):
        news = self._lab.browser.evaluate(RECEIVED % self._name)
        if news:
            self._note_news()
            self._raw += news
            self._shown = ANSI.sub('', self._raw).replace(' \r', '').replace('\r', '')  # bash wraps lines by ' \r'
        return self._shown

    def silent_for(self):
        """Return how long [s] it printed nothing."""
        _ = self._output
        return super().silent_for()

    def send(self, text):
        """Send key presses as the terminal in the page does."""
        self._lab.browser.evaluate(SEND % (self._name, json.dumps(text.replace('\n', '\r'))))
        self._note_news()

    def close(self, timeout):
        """End the program; return the list of programs that did not end. JupyterLab ends the shell."""
        return self.end_program(timeout)
