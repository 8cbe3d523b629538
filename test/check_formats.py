"""Checks what ./run grade --format writes by the schemas and readers of other systems, which are not in here.

usage: python3 test/check_formats.py FOLDER

FOLDER holds, from the repositories of these systems:
  result-v1.schema.json, runner.py, collect_scores.py    foundation50/classroom50: schemas/, .github/scripts/
  junit-10.xsd                                           jenkinsci/xunit-plugin: src/main/resources/.../xsd/
  vpl_submission.class.php, locallib.php                 jcrodriguez-dis/moodle-mod_vpl
The packages jsonschema and xmlschema and the program php are needed. Exit code 0 when every system takes what it gets.
"""
import importlib.util
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import jsonschema
import xmlschema

from course_grader.formats import systems
from unit_support.gradings import VERDICTS, grading

CLASSROOM, ASSIGNMENT, OWNER = 'ros', 'stop', 'anna'
ENVIRONMENT = {'CLASSROOM': CLASSROOM, 'ASSIGNMENT': ASSIGNMENT, 'OWNER': OWNER,
               'SUBMISSION_TAG': 'submit/2026-11-22T10-00-00Z-abc1234',
               'COMMIT_URL': 'https://example.org/c', 'RELEASE_URL': 'https://example.org/r',
               'VPL_GRADEMIN': '0', 'VPL_GRADEMAX': '10'}
READ_VPL = r'''
$text = stream_get_contents(STDIN);
echo json_encode([Reader::find_proposedgrade($text), Reader::find_proposedcomment($text)]);
'''


def module(path):
    """Return a Python file as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def functions(source, *names):
    """Return these functions of PHP source."""
    return '\n'.join(re.search(rf'^( *)(?:public static )?function {name}\(.*?^\1\}}', source,
                               re.MULTILINE | re.DOTALL).group() for name in names)


def classroom50(folder, runner, verdict):
    """Return what Classroom 50 says against a grading."""
    schema = jsonschema.Draft202012Validator(json.loads((folder / 'result-v1.schema.json').read_text()))
    systems.write(systems.rendered('classroom50', grading(verdict), runner))
    path = pathlib.Path(runner.folder) / 'result.json'
    if VERDICTS[verdict].outcome == 'undecided':
        return ['there is a result'] if path.exists() else []
    result = json.loads(path.read_text())
    runner, collector = module(folder / 'runner.py'), module(folder / 'collect_scores.py')
    found = [error.message for error in schema.iter_errors(result)]
    found += filter(None, [runner.validate_result(result, classroom=CLASSROOM, assignment=ASSIGNMENT, owner=OWNER)])
    collector.validate_result(result, CLASSROOM, ASSIGNMENT, OWNER)  # raises ValueError
    status = runner.derive_status_and_summary(result)[0]
    if status != {'passed': 'success', 'failed': 'failure'}[VERDICTS[verdict].outcome]:
        found.append(f'the status is {status}')
    return found


def junit(folder, runner, verdict):
    """Return what Jenkins says against a grading."""
    schema = xmlschema.XMLSchema(str(folder / 'junit-10.xsd'))
    return [str(error) for error in schema.iter_errors(systems.rendered('junit', grading(verdict), runner).stdout)]


def vpl(folder, runner, verdict):
    """Return what VPL reads wrong of a grading."""
    source = (folder / 'vpl_submission.class.php').read_text()
    tags = '\n'.join(re.findall(r'^ *const \w*TAG = .*$', source, re.MULTILINE))
    program = (functions((folder / 'locallib.php').read_text(), 'vpl_detect_newline')
               + 'class Reader {' + tags + functions(source, 'find_proposedgrade', 'find_proposedcomment') + '}'
               + READ_VPL)
    stdout = systems.rendered('vpl', grading(verdict), runner).stdout
    done = subprocess.run(['php', '-r', program], input=stdout.encode(), stdout=subprocess.PIPE, check=True)
    grade, comment = json.loads(done.stdout)
    decided = VERDICTS[verdict]
    expected = '' if decided.outcome == 'undecided' else f'{round(decided.score / 10, 2):g}'
    lines = comment.splitlines()
    whole = lines[0].startswith('-') and all(line.startswith('>') for line in lines[1:])
    return ([] if grade == expected else [f'the grade is {grade!r}, not {expected!r}']) + (
        [] if whole and len(lines) == stdout.count('\n>') + 1 else [f'the comment is {comment!r}'])


def main():
    """Check every grading in every format; return the exit code."""
    folder, wrong = pathlib.Path(sys.argv[1]).resolve(), 0
    with tempfile.TemporaryDirectory() as current:
        runner = systems.Runner(ENVIRONMENT, current, os.path.join(current, 'autograder'))
        for check in (classroom50, junit, vpl):
            for verdict in VERDICTS:
                found = check(folder, runner, verdict)
                wrong += bool(found)
                print(f'{"FAILED" if found else "ok":8}{check.__name__}, {verdict}', *found, sep='\n        ')
    return int(wrong > 0)


if __name__ == '__main__':
    sys.exit(main())
