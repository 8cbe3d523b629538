"""course_grader.formats.harmless: nothing that a student writes commands a terminal, a log or a spreadsheet."""
import pytest

from course_grader.formats import harmless


@pytest.mark.parametrize('text, expected', [
    ('a\tb\nc é 🐢', 'a\tb\nc é 🐢'),
    ('\x1b[31m \x00 \r \x7f \x9b', '?[31m ? ? ? ?'),
    ('\udcff \ufffe', '? ?'),  # an undecodable byte; no character
    ('a\u202eb\u2028c', 'a?b?c'),  # writes backwards; a line separator
])
def test_plain_text_has_no_control_characters(text, expected):
    assert harmless.plain(text) == expected


@pytest.mark.parametrize('text, expected', [
    ('::error::no', ': :error::no'),
    ('seen\n  ::set-output name=a::b', 'seen\n  : :set-output name=a::b'),
    ('\u00a0::warning::', '\u00a0: :warning::'),  # GitHub skips any kind of blank before it
    ('std::string', 'std::string'),
    ('a ##[group]', 'a # #[group]'), ('##vso[task.complete]', '# #vso[task.complete]'),
    ('##teamcity[testFailed]', '# #teamcity[testFailed]'), ('## A heading', '## A heading'),
    ('Grade :=>> 100', 'Grade : =>> 100'), ('Comment :=>>x', 'Comment : =>>x'),
    ('<|--\n--|>', '< |--\n-- |>'),
])
def test_marks_of_other_systems_are_taken_apart(text, expected):
    assert harmless.printed(text) == expected
    assert harmless.printed(expected) == expected


@pytest.mark.parametrize('text, expected', [
    ('anna', 'anna'), ('=1+1', "'=1+1"), ('+49', "'+49"), ('-1', "'-1"), ('@SUM(A1)', "'@SUM(A1)"),
    (' =1', "' =1"), ('\t=1', "'\t=1"), ('\uff1d1', "'\uff1d1"),
    ('two\nlines', 'two lines'), ('87.5', '87.5'), ('', ''),
])
def test_no_cell_is_a_formula(text, expected):
    assert harmless.cell(text) == expected


def test_a_fence_is_longer_than_those_in_its_text():
    assert harmless.fenced('a\n````\n<b>') == '`````text\na\n````\n<b>\n`````\n'
    assert harmless.fenced('a') == '```text\na\n```\n'
