#!/usr/bin/env python3
"""List the texts that users can see as FILE:LINE: TEXT, to read all of them as a student does.

Of Python these are the strings of at least two words that are not docstrings, with {} for each value; of bash and of
launch, message, service and exercise files, the messages, `doc` attributes, comments and sentences.
"""
import ast
import re
import subprocess
import sys

import yaml

READERS = {}
UNSEEN = re.compile(r'test/.*/|setup\.py|tools/user_texts\.py|tools/bench/\w+_probe\.py')
WORDS = re.compile(r'[A-Za-z]{2,}[,;:.)]* .*[A-Za-z]{2,}', re.DOTALL)


def reader(*endings):
    """Register a function that yields (line, text) of a file's content for names with one of ``endings``."""
    return lambda function: READERS.update(dict.fromkeys(endings, function)) or function


@reader('.py', '.cfg')
def python_texts(content):
    """Yield the strings of a program, and its docstring where the program prints that."""
    tree = ast.parse(content)
    expressions = (node.value for node in ast.walk(tree) if isinstance(node, ast.Expr))
    hidden = {id(value) for value in expressions if isinstance(value, ast.Constant)}
    if '__doc__' in content:
        hidden.discard(id(tree.body[0].value))
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            parts = node.values
            yield node.lineno, ''.join(part.value if isinstance(part, ast.Constant) else '{}' for part in parts)
            hidden.update(map(id, parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in hidden:
            yield node.lineno, node.value


@reader('.bash', 'run')
def bash_texts(content):
    """Yield the quoted strings and the lines of here-documents."""
    end = None
    for number, line in enumerate(content.splitlines(), 1):
        start = re.search(r'<<-?(\w+)', line)
        if end and line.strip() != end:
            yield number, line.strip()
        elif end or start:
            end = start and start.group(1)
        elif not line.lstrip().startswith('#'):
            for text in re.findall(r'"(?:\\.|[^"\\])*"|\'[^\']*\'', line):
                yield number, text[1:-1]


@reader('.launch')
def launch_texts(content):
    """Yield the texts that roslaunch --ros-args prints."""
    for match in re.finditer(r'\bdoc="([^"]*)"', content):
        yield content.count('\n', 0, match.start()) + 1, match.group(1)


@reader('.msg', '.srv')
def message_texts(content):
    """Yield the comments, which rosmsg show -r prints."""
    for number, line in enumerate(content.splitlines(), 1):
        yield number, line.partition('#')[2].strip()


@reader('.yaml')
def yaml_texts(content):
    """Yield the scalars."""
    pending = [yaml.compose(content)]
    while pending:
        node = pending.pop()
        if isinstance(node, yaml.ScalarNode):
            yield node.start_mark.line + 1, node.value
        elif isinstance(node, yaml.MappingNode):
            pending += [value for _, value in reversed(node.value)]
        elif node:
            pending += reversed(node.value)


def texts_of(path):
    """Yield (line, text) of the texts in the file ``path`` that a user can see."""
    for ending, read in READERS.items():
        if path.endswith(ending) and not UNSEEN.match(path):
            with open(path, encoding='utf-8') as file:
                yield from ((line, ' '.join(text.split())) for line, text in read(file.read()) if WORDS.search(text))


def main():
    """Print the texts of the files of this repository, or of those whose path starts with one of the arguments."""
    paths = subprocess.run(['git', 'ls-files', '--', *sys.argv[1:]], stdout=subprocess.PIPE, check=True, text=True)
    for path in paths.stdout.split():
        for line, text in texts_of(path):
            print(f'{path}:{line}: {text}')


if __name__ == '__main__':
    main()
