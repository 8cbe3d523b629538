"""The browser of the tests sees the errors of a page."""
import pytest

from rostest_support import browser

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)]


def test_errors_of_the_page_are_seen_once(tmp_path):
    page = tmp_path / 'a page.html'
    page.write_text('<!doctype html><script>console.error("broken on purpose")</script>')
    with browser.Browser() as opened:
        opened.get(str(page))
        assert any('broken on purpose' in error for error in opened.errors())
        assert opened.errors() == []
