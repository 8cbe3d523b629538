"""Makes names and printed lines of a student harmless before they reach a terminal or another system.

A log of GitHub or Azure takes ``::set-output``, ``##[error]`` and ``##vso[...]`` for commands, one of TeamCity
``##teamcity[...]``, Moodle's VPL ``Grade :=>> 100``; a spreadsheet takes ``=1+1`` for a formula; a terminal follows
escape sequences; XML cannot hold control characters at all.
"""
import re

FORBIDDEN = re.compile('[\x00-\x08\x0b-\x1f\x7f-\x9f'  # control characters, except tab and line feed
                       '\u2028-\u202e\u2066-\u2069\u061c\u200e\u200f'  # line separators; direction of writing
                       '\u200b\ufeff'  # spaces without a width
                       '\ud800-\udfff\ufffe\uffff]')  # not characters, such as undecodable bytes
MARK = re.compile(r'(^[^\S\n]*:(?=:)'  # a workflow command starts a line with ::
                  r'|#(?=#\w*\[)'  # its older form, of TeamCity and Azure, too, stands anywhere
                  r'|:(?==>>)|<(?=\|--)|--(?=\|>))', re.MULTILINE)  # VPL: a grade or a comment, a block of comments
FORMULA = re.compile(r'\s*[=+\-@\t\uff1d\uff0b\uff0d\uff20]')


def plain(text: str) -> str:
    """Return a text with ``?`` for each character that XML or a terminal cannot hold."""
    return FORBIDDEN.sub('?', text)


def printed(text: str) -> str:
    """Return lines for a terminal or a log; a space breaks up what a system would read as a command."""
    return MARK.sub(r'\1 ', plain(text))


def cell(text: str) -> str:
    """Return the cell of a CSV table; an apostrophe precedes what a spreadsheet would read as a formula."""
    line = ' '.join(plain(text).split('\n'))
    return f"'{line}" if FORMULA.match(line) else line


def fenced(text: str) -> str:
    """Return a block of Markdown that shows a text unchanged, whatever it contains."""
    content = plain(text)
    fence = '`' * max(3, 1 + max(map(len, re.findall('`+', content)), default=0))
    return f'{fence}text\n{content}\n{fence}\n'
