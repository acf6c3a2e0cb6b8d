"""What the scripts with foreign clients share: checks that say what they compared, and the layout of a call.

Standard library only. A failed check ends the script with exit code 1.
"""

import struct
import sys
import time

# Type codes of CIP data (contract, section 4).
DINT, REAL, SHORT_STRING = 0x00C4, 0x00CA, 0x00DA

# Bits of MOTION_INSTRUCTION.FLAGS.
EN, DN, ER, PC, IP, AC = (1 << bit for bit in (31, 29, 28, 27, 26, 23))

MOTION_AXIS, COORDINATE_SYSTEM, MOTION_INSTRUCTION = 0x0301, 0x0302, 0x0303
GET_ATTRIBUTES_ALL, MCLM, MCS = 0x01, 0x32, 0x35


def equal(what, found, expected):
    if found != expected:
        sys.exit(f"FAILED {what}: found {found!r}, expected {expected!r}")
    print(f"ok  {what}")


def holds(what, condition, found=""):
    if not condition:
        sys.exit(f"FAILED {what}: {found!r}")
    print(f"ok  {what}")


def eventually(what, look, seconds=20.0):
    """Calls look() until it gives something true, and gives that back."""
    deadline = time.monotonic() + seconds
    while True:
        value = look()
        if value:
            print(f"ok  {what}")
            return value
        if time.monotonic() > deadline:
            sys.exit(f"FAILED {what}: not within {seconds} s")
        time.sleep(0.01)


def name(text):
    data = text.encode()
    return struct.pack("<HHB", SHORT_STRING, 1, len(data)) + data


def dint(value):
    return struct.pack("<HHi", DINT, 1, value)


def reals(*values):
    return struct.pack(f"<HH{len(values)}f", REAL, len(values), *values)


def linear_move(control, position, speed):
    """Operands of MCLM behind the coordinate system: absolute, S-curve, jerk in % of time, No Settle."""
    return b"".join((
        name(control), dint(0), reals(*position),
        reals(speed), dint(0), reals(2000.0), dint(0), reals(2000.0), dint(0),
        dint(1), reals(100.0), reals(100.0), dint(2), dint(1),
    ))


def motion_instruction(data):
    """FLAGS, ERR, EXERR of the 16 bytes of a MOTION_INSTRUCTION."""
    flags, err, _status, _state, _segment, exerr = struct.unpack_from("<Ihbbib", data)
    return flags, err, exerr


def watch_straight_line(what, sample, start, end, ended):
    """Samples positions until ended(); they lie on the line from start to end, and never go back along it."""
    span = [b - a for a, b in zip(start, end)]
    length = sum(x * x for x in span) ** 0.5
    along, samples, inside = 0.0, 0, 0
    deadline = time.monotonic() + 30.0
    while True:
        over = ended()
        position = sample()
        offset = [p - a for p, a in zip(position, start)]
        s = sum(x * y for x, y in zip(offset, span)) / length
        distance = sum((o - s * x / length) ** 2 for o, x in zip(offset, span)) ** 0.5
        if distance > 1e-3:
            sys.exit(f"FAILED {what}: {position} is {distance} off the line")
        if s < along - 1e-3:
            sys.exit(f"FAILED {what}: went back from {along} to {s}")
        along, samples = max(along, s), samples + 1
        inside += 0.01 * length < s < 0.99 * length
        if over:
            break
        if time.monotonic() > deadline:
            sys.exit(f"FAILED {what}: has not ended")
    holds(f"{what}: seen on the way ({inside} of {samples} samples)", inside >= 2, (inside, samples))
