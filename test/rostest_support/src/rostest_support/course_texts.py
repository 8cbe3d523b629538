"""Extract programs and commands from the texts of the course, which are not part of the repository.

The texts are printed slides and a web page: programs have lost their indentation, continue over several slides and have
typographic quotes. This module repairs them as a student does who types them, and changes nothing else.
"""
import re
import textwrap
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[5] / 'shared' / 'seeds'
MISSING = (f'the course texts are not in {FOLDER}: the programs of the course are NOT tested. '
           'Put the folder "shared" beside the repository to test them.')

SHEBANG = '#!/usr/bin/env python'
SLIDE_HEAD = 3  # lines that each slide begins with: section, chapter, title
ROBOT_LOOP = '''velocity = Twist()
velocity.linear.x = 0.2
rate = rospy.Rate(1)
while not rospy.is_shutdown():
    velocity_pub.publish(velocity)
    rospy.loginfo(velocity)
    rate.sleep()
'''
QUOTES = str.maketrans({'\u2018': "'", '\u2019': "'", '\u201c': '"', '\u201d': '"'})


def text(number):
    """Return the course text with a number, 0 to 2, with plain quotes."""
    path, = FOLDER.glob(f'{number:03d}_*.txt')
    return path.read_text(encoding='utf-8').translate(QUOTES)


def programs(course):
    """Return the programs of a text, indented: from a shebang line to an empty line or to the end of its main part."""
    lines = without_slides(course.splitlines())
    starts = [number for number, line in enumerate(lines) if line.startswith(SHEBANG)]
    return [indented(one_program(lines[start:])) for start in starts]


def function(course, name):
    """Return the source of a function that is printed separately, up to its return."""
    lines = course.splitlines()
    start = max(number for number, line in enumerate(lines) if line.startswith(f'def {name}('))
    end = next(number for number in range(start, len(lines)) if lines[number].startswith('return'))
    return indented(lines[start:end + 1])


def commands(course, program):
    """Return (command, lines printed below it) of each command line of a program that can be typed unchanged."""
    lines = course.splitlines()
    return [(line[2:], lines[number + 1:]) for number, line in enumerate(lines)
            if line.startswith(f'$ {program} ') and '[' not in line]


def snippets(course, *beginnings):
    """Return the code of a web page that begins with each of these, one after the other, without its margin."""
    blocks = [textwrap.dedent(block).strip() for block in re.findall(r'(?m)(?:^ {4}.*\n)+', course)]
    return [next(block for block in blocks if re.search(beginning, block)) for beginning in beginnings]


def endless():
    """Return {name: source} of the programs of all texts that run until they are ended.

    The last one is put together of a page's pieces; its loop is said in words only: a Twist that goes forward,
    published and printed once a second. The service is printed without the rospy.spin() that it needs.
    """
    (publisher, subscriber), (both, service) = programs(text(0)), programs(text(1))
    pieces = snippets(text(2), 'import Twist', 'import AlvarMarkers', 'def ar_message_handler', 'init_node',
                      'rospy.Publisher')
    robot = '\n'.join(['#!/usr/bin/env python', 'import rospy', *pieces, ROBOT_LOOP])
    return {'publisher': publisher, 'pose_subscriber': subscriber, 'pub': both, 'service': f'{service}rospy.spin()\n',
            'ar_control_node': robot}


def without_slides(lines):
    """Return the lines without the break in the middle of a program: a line with an address, the next slide's head."""
    kept, head = [], 0
    for line in lines:
        if 'https://' in line:
            head = SLIDE_HEAD
        elif head:
            head -= 1
        else:
            kept.append(line)
    return kept


def one_program(lines):
    main = False
    for number, line in enumerate(lines):
        main = main or line.startswith('if __name__')
        if not line.strip():
            return lines[:number]
        if main and line.strip() == 'pass':
            return lines[:number + 1]
    return lines


def indented(lines):
    """Return the source with the indentation that its lines have lost.

    A line that ends with a colon is followed by a block. Blocks end where a function or the main part begins, and at
    an except, which belongs to the try before it. That is all that the course's programs need.
    """
    result, depth, tries = [], 0, []
    for line in lines:
        if re.match(r'def |if __name__', line):
            depth = 0
        elif line.startswith('except'):
            depth = tries.pop()
        elif line.startswith('try:'):
            tries.append(depth)
        result.append(' ' * 4 * depth + line)
        if line.rstrip().endswith(':') and not line.startswith('#'):
            depth += 1
    return '\n'.join(result) + '\n'
