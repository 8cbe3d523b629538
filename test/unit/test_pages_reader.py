"""test/pages/page.py reads the actions of a page, and compares output with the page."""
import pytest

from pages import page
from unit_support import REPOSITORY

SAMPLE = '''# Title
```bash
./run demo
```

```bash
roscore            # terminal 1
rosrun a b _c:="d  e"   # terminal 2
rosrun a f
```

Text. Terminal 1 prints

```text
x: 1.0
...
y
```

![a picture](images/a.png)

In
terminal 2 press <kbd>↑</kbd> <kbd>q</kbd>, and in terminal 1 press <kbd>Ctrl</kbd>+<kbd>C</kbd>.

Write this as `c.py`:

```python
pass
```

A part of it:

```python
pass
```

Save it as
`~/ws/d.launch`:

<!-- file: launch/d.launch -->
```xml
<launch/>
```

[e.py](../scripts/e.py) is shown:

<!-- file: ../scripts/e.py -->
```python
pass
```

```
not run
```
'''


def test_actions_of_a_page():
    assert page.actions(SAMPLE) == [
        page.Command(0, './run demo'), page.Command(1, 'roscore'), page.Command(2, 'rosrun a b _c:="d  e"'),
        page.Command(2, 'rosrun a f'), page.Output(1, ('x: 1.0', 'y')), page.Picture('images/a.png'),
        page.Keys(2, ('\x1b[A', 'q')), page.Keys(1, ('\x03',)), page.File(1, 'c.py', 'pass\n'),
        page.File(1, '~/ws/d.launch', '<launch/>\n')]


@pytest.mark.parametrize('text, message', [
    ('press <kbd>q</kbd>', 'does not say "in terminal N press"'),
    ('in terminal 1 press <kbd>F13</kbd>', 'there is no key F13'),
    ('```text\nx\n```\n', 'output before any command'),
    ('```bash\nls\npwd # terminal 2\n```\n', 'names no terminal'),
    ('```bash\nls # terminal 2\n```\nText\n\n<!-- file: a.py -->\n```python\npass\n```\n',
     'does not say "as `NAME.py`"'),
])
def test_what_cannot_be_read_is_named(text, message):
    with pytest.raises(page.PageError, match='.*' + message.replace('`', '.')):
        page.actions(text)


@pytest.mark.parametrize('expected, printed, fit', [
    ('a', 'a', True), ('a', 'a ', True), ('a', 'ab', False), ('a...', 'ab', True), ('a.b', 'a+b', False),
    ('x: 1.50', 'x: 1.5049', True), ('x: 1.50', 'x: 1.56', False), ('x: -1.5', 'x: 1.5', False),
    ('rate: 62.5', 'rate: 61.4', True), ('rate: 62.5', 'rate: 60.0', False),  # 2 %
    ('5 of 5', '4 of 5', False), ('5 of 5', '5 of 5', True),
    ('y: 0.0', 'y: 1e-05', True), ('y: 0.0', 'y: 0', True),
    ('[INFO] [1795330816.632369]: x', '[INFO] [1795999999.1]: x', True), ('in ... s', 'in 12.5 m', False),
])
def test_printed_lines(expected, printed, fit):
    assert page.fits(expected, printed) is fit


@pytest.mark.parametrize('printed, first', [
    (['a', 'x', 'b'], None), (['b', 'a'], 'b'), ([], 'a'), (['a'], 'b'),
])
def test_lines_come_in_their_order(printed, first):
    assert page.missing(['a', 'b'], printed) == first


@pytest.mark.parametrize('name', ['README.md', 'course/03_stop_at_x/README.md', 'course/19_record_and_play/README.md'])
def test_pages_can_be_read(name):
    actions = page.actions((REPOSITORY / name).read_text(encoding='utf-8'))
    assert sum(isinstance(action, page.Output) for action in actions) >= 2
