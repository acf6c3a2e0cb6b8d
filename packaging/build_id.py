"""Gives a stripped program an id of its build that follows from its own bytes: build_id.py PROGRAM

The linker's id is a hash over debug information too, and so over the folder that the sources stand in, though nothing else of it stays in the program.
"""

import hashlib
import sys
from pathlib import Path

# An ELF note: lengths of name and content, the type NT_GNU_BUILD_ID, the name.
NOTE = b"\x04\0\0\0\x14\0\0\0\x03\0\0\0GNU\0"
LENGTH = 20


def main(program):
    file = Path(program)
    content = file.read_bytes()
    if content.count(NOTE) != 1:
        sys.exit(f"{program}: expected one id of the build, found {content.count(NOTE)}")
    at = content.index(NOTE) + len(NOTE)
    front, behind = content[:at], content[at + LENGTH :]
    file.write_bytes(front + hashlib.sha1(front + bytes(LENGTH) + behind).digest() + behind)


if __name__ == "__main__":
    main(*sys.argv[1:])
