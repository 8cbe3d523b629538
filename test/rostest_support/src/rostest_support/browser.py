"""A real browser for tests: Chromium without a display, driven by selenium (Debian: chromium-driver, python3-selenium).

    with Browser(width=390, height=844, dark=True) as browser:
        browser.get(address)
        browser.until(lambda: browser.find('#turtle'), 'the canvas is there')
        browser.screenshot('turtle_phone_dark')
        assert browser.errors() == []
"""
import json
import os
import shutil
import tempfile
import time

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    _FOUND = all(map(shutil.which, ('chromium', 'chromedriver')))
except ImportError:
    _FOUND = False

MISSING = '' if _FOUND else ('Chromium is missing, the pages are NOT tested: '
                             'sudo apt install chromium chromium-driver python3-selenium')
TIMEOUT = 30.0  # [s]

# Without these, Chromium asks hosts of its maker for updates and settings at every start.
_ARGUMENTS = ('--headless=new', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
              '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage', '--force-color-profile=srgb',
              '--hide-scrollbars')


class Browser:
    """A Chromium of its own, with an empty profile; use it in a with statement. ``driver`` is selenium's driver.

    ``width`` and ``height`` [CSS px] are those of the page; ``dark`` is what ``prefers-color-scheme`` says; with
    ``touch`` it is a phone. ``folder`` gets the screenshots; default: the results of the test case, else the current
    folder. Raise WebDriverException where Chromium does not start.
    """

    def __init__(self, width=1280, height=800, dark=False, touch=False, folder=None):
        self.folder = folder or os.environ.get('TURTLE_ROBOTONT_CASE') or '.'
        self._profile = tempfile.mkdtemp()
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which('chromium')
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        for argument in (*_ARGUMENTS, f'--user-data-dir={self._profile}'):
            options.add_argument(argument)
        if os.getuid() == 0:
            options.add_argument('--no-sandbox')  # Chromium's sandbox does not start for root
        try:
            self.driver = webdriver.Chrome(service=Service(shutil.which('chromedriver')), options=options)
        except WebDriverException:
            shutil.rmtree(self._profile, ignore_errors=True)
            raise
        self.resize(width, height, touch)
        self.prefer(dark)

    def devtools(self, method, **parameters):
        """Return the result of a command of the Chrome DevTools Protocol."""
        return self.driver.execute_cdp_cmd(method, parameters)

    def resize(self, width, height, touch=False):
        """Give the page a size [CSS px]; with ``touch``, it reports a touch screen."""
        self.devtools('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1,
                      mobile=touch)
        self.devtools('Emulation.setTouchEmulationEnabled', enabled=touch)

    def prefer(self, dark=False, media=''):
        """Set ``prefers-color-scheme``; with ``media='print'``, show the page as printed."""
        self.devtools('Emulation.setEmulatedMedia', media=media, features=[
            {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}])

    def get(self, address):
        """Open an address, or a file of this machine."""
        self.driver.get('file://' + os.path.abspath(address) if os.path.exists(address) else address)

    def find(self, selector):
        """Return the elements that match a CSS selector."""
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def evaluate(self, expression):
        """Return the value of a JavaScript expression; a promise is waited for."""
        result = self.devtools('Runtime.evaluate', expression=expression, awaitPromise=True, returnByValue=True)
        if 'exceptionDetails' in result:
            details = result['exceptionDetails']
            raise AssertionError(f'{expression}: {details.get("exception", details).get("description", details)}')
        return result['result'].get('value')

    def call(self, path, function, *arguments):
        """Return what a function of the JavaScript in a file returns; both ways, values are those of JSON."""
        with open(path, encoding='utf-8') as file:
            self.evaluate(f'{{{file.read()}}}; void 0')  # in a block, so that it can be loaded again
        return json.loads(self.evaluate(
            f'(async () => JSON.stringify(await {function}(...{json.dumps(arguments)}) ?? null))()'))

    def until(self, condition, what, timeout=TIMEOUT):
        """Return the value of ``condition()`` as soon as it is true; raise AssertionError after ``timeout`` [s].

        A page that replaces its elements in between is asked again. The message has what the page shows and logs.
        """
        deadline = time.monotonic() + timeout
        while True:
            try:
                value = condition()
                if value:
                    return value
            except WebDriverException:
                pass  # an element was replaced while it was read
            if time.monotonic() > deadline:
                text = self.evaluate('document.body.innerText') or ''
                raise AssertionError(f'not within {timeout:.0f} s: {what}\nthe page shows: {text[:2000]}\n'
                                     f'the console: {self.errors()}')
            time.sleep(0.05)

    def touch(self, *points):
        """Put fingers on the page at ``points`` (x, y) [CSS px]; without points, lift them."""
        self.devtools('Input.dispatchTouchEvent', type='touchStart' if points else 'touchEnd',
                      touchPoints=[{'x': x, 'y': y, 'id': index} for index, (x, y) in enumerate(points)])

    def screenshot(self, name):
        """Save a screenshot as NAME.png in ``folder`` and return its path."""
        path = os.path.join(self.folder, f'{name}.png')
        if not self.driver.save_screenshot(path):
            raise OSError(f'cannot write {path}')
        return path

    def errors(self):
        """Return the texts of errors that the page has logged since the last call."""
        return [entry['message'] for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE']

    def frame_times(self, seconds=2.0):
        """Return the times [ms] between the frames that the page draws in the next ``seconds``."""
        return json.loads(self.evaluate(
            f'''new Promise(done => {{
                const times = []; let last;
                const frame = now => {{
                    if (last !== undefined) times.push(now - last);
                    last = now;
                    if (times.reduce((sum, t) => sum + t, 0) < {1000 * seconds}) requestAnimationFrame(frame);
                    else done(JSON.stringify(times));
                }};
                requestAnimationFrame(frame);
            }})'''))

    def close(self):
        """End the browser with all its processes."""
        self.driver.quit()
        shutil.rmtree(self._profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
