"""The browser of the tests sees the text, the log and the requests of a page."""
import pytest

from rostest_support import browser

pytestmark = pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)

PAGE = '''<!doctype html><meta charset=utf-8><style>
body { background: white; margin: 0 } @media (prefers-color-scheme: dark) { body { background: black } }
</style><button onclick="this.textContent = 'pressed'">press</button>
<script>
addEventListener('touchstart', event => { document.title = `${event.touches.length} fingers`; });
console.error('broken on purpose');
</script>'''


@pytest.fixture(scope='module')
def opened(tmp_path_factory):
    folder = tmp_path_factory.mktemp('page')
    page = folder / 'a page.html'
    page.write_text(PAGE, encoding='utf-8')
    with browser.Browser(width=390, height=600, dark=True, touch=True, folder=str(folder)) as opened_browser:
        opened_browser.get(str(page))
        yield opened_browser


def test_errors_of_the_page_are_seen_once(opened):
    assert any('broken on purpose' in error for error in opened.errors())
    assert opened.errors() == []


def test_buttons_and_fingers_reach_the_page(opened):
    opened.find('button')[0].click()
    opened.until(lambda: opened.find('button')[0].text == 'pressed', 'the button was pressed')
    opened.touch((10, 300), (60, 300))
    opened.until(lambda: opened.driver.title == '2 fingers', 'two fingers were seen')
    opened.touch()


def test_the_page_has_the_size_and_the_colours_that_were_asked_for(opened):
    cv2 = pytest.importorskip('cv2')
    picture = cv2.imread(opened.screenshot('dark'))
    assert picture.shape[:2] == (600, 390)
    assert tuple(picture[500, 200]) == (0, 0, 0)
    opened.prefer(dark=False)
    assert tuple(cv2.imread(opened.screenshot('light'))[500, 200]) == (255, 255, 255)


def test_frames_are_counted(opened):
    assert sum(opened.frame_times(0.2)) >= 200  # [ms]


def test_what_never_comes_is_named_with_what_the_page_shows(opened):
    with pytest.raises(AssertionError, match='(?s)a unicorn.*press'):
        opened.until(lambda: False, 'a unicorn', timeout=0.1)
    with pytest.raises(AssertionError, match='nothing_of_the_kind'):
        opened.evaluate('nothing_of_the_kind()')
