"""Read untrusted YAML and XML files: every malformed file raises a DocumentError, and none takes long.

Size, depth and the entries that aliases or entities multiply are limited; tags in a file never create Python objects.
"""
import os
from typing import Any, Dict, Optional, Union
from xml.etree import ElementTree
from xml.parsers import expat

import yaml

MAX_YAML = 1_000_000  # [bytes]; PyYAML takes about ten seconds for them
MAX_XML = 100_000_000  # [bytes]
DEEPEST = 100  # nested elements or lists
MAX_ENTRIES = 100_000  # of a YAML file, with its aliases written out

Path = Union[str, 'os.PathLike[str]']


class DocumentError(ValueError):
    """A file is not YAML or XML, or exceeds the limits; the text says where and why, but does not name the file."""


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file: dicts, lists, texts, numbers. Raise DocumentError or OSError."""
    return parse_yaml(_read(path, MAX_YAML))


def parse_yaml(text: Union[str, bytes]) -> Any:
    """Return the content of a YAML text (str or UTF-8); raise DocumentError."""
    loader = None
    try:
        loader = _Loader(text.decode('utf-8') if isinstance(text, bytes) else text)
        node = loader.get_single_node()
        if node is None:
            return None
        _entries(node, {})
        return loader.construct_document(node)
    except UnicodeDecodeError as error:
        raise DocumentError(f'not UTF-8 text: {error.reason} at byte {error.start}') from None
    except yaml.YAMLError as error:
        raise DocumentError('not YAML: ' + ' '.join(str(error).split())) from None
    except (ValueError, TypeError, AttributeError, KeyError, IndexError, OverflowError, RecursionError) as error:
        # PyYAML's own errors, for values whose tag does not fit
        raise DocumentError(f'not YAML: {error!r:.200}') from None


def read_xml(path: Path) -> ElementTree.Element:
    """Return the root Element of an XML file; raise DocumentError or OSError."""
    return parse_xml(_read(path, MAX_XML))


def parse_xml(content: Union[str, bytes]) -> ElementTree.Element:
    """Return the root Element of an XML document (str or bytes); raise DocumentError."""
    parser, builder, depth = expat.ParserCreate(), ElementTree.TreeBuilder(), [0]
    parser.buffer_text = True

    def start(tag: str, attributes: Dict[str, str]) -> None:
        depth[0] += 1
        if depth[0] > DEEPEST:
            raise DocumentError(f'line {parser.CurrentLineNumber}: <{tag:.80}> lies in {DEEPEST} elements; at most '
                                f'{DEEPEST - 1} are allowed')
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        depth[0] -= 1
        builder.end(tag)

    def entity(name: str, *_: object) -> None:
        raise DocumentError(f'line {parser.CurrentLineNumber}: it defines the entity {name:.80}; write the text '
                            'of the entity instead')
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.EntityDeclHandler = builder.data, entity
    try:
        parser.Parse(content, True)
        return builder.close()
    except DocumentError:
        raise
    except (expat.ExpatError, AssertionError, LookupError, ValueError) as error:
        raise DocumentError(f'not XML: {error}') from None


def _read(path: Path, largest: int) -> bytes:
    with open(path, 'rb') as file:
        content = file.read(largest + 1)
    if len(content) > largest:
        raise DocumentError(f'it is too large; at most {largest / 1e6:g} MB are allowed')
    return content


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML comes without types
    """A SafeLoader that limits the depth of nested lists and mappings."""

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self._depth += 1
        if self._depth > DEEPEST:
            raise yaml.MarkedYAMLError(problem=f'more than {DEEPEST} lists or mappings are nested',
                                       problem_mark=self.peek_event().start_mark)
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1


def _entries(node: Any, known: Dict[int, Optional[int]]) -> int:
    """Return the number of entries of a node with its aliases written out; raise YAMLError if there are too many."""
    number = known.get(id(node))
    if number is None and id(node) in known:
        raise yaml.MarkedYAMLError(problem='it contains itself', problem_mark=node.start_mark)
    if number is None:
        known[id(node)] = None
        number = 1
        if isinstance(node, yaml.CollectionNode):
            for entry in node.value:
                for part in entry if isinstance(entry, tuple) else (entry,):
                    number += _entries(part, known)
        known[id(node)] = number
    if number > MAX_ENTRIES:
        raise yaml.MarkedYAMLError(problem=f'it has more than {MAX_ENTRIES} entries, counting those of aliases',
                                   problem_mark=node.start_mark)
    return number
