#!/usr/bin/env python3
"""Random ladder programs in Arcline and in l5x2c, scan by scan.

    git clone https://github.com/alairjunior/l5x2c && pip install ply ./python
    python tests/rivals/l5x2c.py l5x2c [--programs 300] [--scans 100] [--seed 1] [--known]

l5x2c (Alair Dias Junior, MIT) translates the rungs of an L5X file to C; a C compiler makes a program of them that this script drives. Both get the same
project, the same values of tags after prescan and the same inputs before each scan; every tag must be the same after it. The rungs have the instructions
that both execute: XIC XIO ONS EQU NEQ GEQ GRT OTE OTL OTU MOV ADD SUB DIV CLR CPT TON TOF CTU JSR, in branches within one another.

With --known the rungs also have what is known to differ, and the script counts the programs that differ for each:

- LEQ: l5x2c compares with `<`, so equal values are false.
- LIM: l5x2c leaves the limits themselves out.
- RES: l5x2c clears ACC alone; the manual clears EN, TT and DN of a timer, and the bits of a counter, too.
- TON in a subroutine: l5x2c adds the time of one scan whenever it executes the timer, a controller the time since it did so last.
- ONS in a leg of a branch of conditions: l5x2c gives it the condition of its leg, not that of the rung and the leg.

Negative numbers are left out: l5x2c writes the minus alone, which no compiler takes.
"""

import argparse
import pathlib
import random
import subprocess
import sys
import tempfile

import arcline

BOOLS = [f"In{n}" for n in range(8)] + [f"Bit{n}" for n in range(8)]
STORAGE = [f"Store{n}" for n in range(24)]
NUMBERS = [f"Num{n}" for n in range(8)]
TIMERS = [f"Time{n}" for n in range(4)]
COUNTERS = [f"Sum{n}" for n in range(4)]
PRESETS = {"TIMER": [30, 70, 10, 200], "COUNTER": [3, 1, 8, 2]}
MEMBERS = {"TIMER": ["PRE", "ACC", "EN", "TT", "DN"], "COUNTER": ["PRE", "ACC", "CU", "CD", "DN", "OV", "UN"]}
# A scan each 10 ms.
SCAN_MS = 10
KNOWN = {
    "LEQ": lambda r: f"LEQ({r.choice(NUMBERS)},{r.choice(NUMBERS)})OTE({r.choice(BOOLS)});",
    "LIM": lambda r: f"LIM({r.choice(NUMBERS)},{r.choice(NUMBERS)},{r.choice(NUMBERS)})OTE({r.choice(BOOLS)});",
    "RES": lambda r: f"XIC({r.choice(BOOLS)})RES({r.choice(TIMERS)});",
    "TON in a subroutine": lambda r: "TON(Time3,?,?);",
    "ONS in a branch": lambda r: f"XIC({r.choice(BOOLS)})[XIO({r.choice(BOOLS)})ONS(Store23) ,XIC({r.choice(BOOLS)}) ]OTE({r.choice(BOOLS)});",
}


class Program:
    """A random program: rungs for one routine and a second one that it calls."""

    def __init__(self, seed, known=None):
        self.random = random.Random(seed)
        self.storage = STORAGE[:-1]
        self.timers, self.counters = [], COUNTERS[:]
        self.sub = [self.rung() for _ in range(self.random.randint(1, 4))]
        self.timers = TIMERS[:-1] if known else TIMERS[:]
        self.main = [self.rung() for _ in range(self.random.randint(3, 12))] + [f"XIC({self.bit()})JSR(Sub,0);"]
        if known:
            into = self.sub if known == "TON in a subroutine" else self.main
            into.append(KNOWN[known](self.random))
        self.random.shuffle(self.main)

    def bit(self):
        bits = [f"{timer}.{member}" for timer in TIMERS for member in ("EN", "TT", "DN")] + [f"{one}.DN" for one in COUNTERS]
        return self.random.choice(BOOLS + bits)

    def number(self):
        choices = NUMBERS + [f"{timer}.ACC" for timer in TIMERS] + [f"{one}.ACC" for one in COUNTERS]
        return self.random.choice([*choices, str(self.random.randint(0, 20))])

    def condition(self):
        compare = self.random.choice(["EQU", "NEQ", "GEQ", "GRT"])
        return self.random.choice(
            [f"XIC({self.bit()})", f"XIO({self.bit()})", f"XIC({self.bit()})", f"{compare}({self.random.choice(NUMBERS)},{self.number()})"]
        )

    def conditions(self, depth=0):
        text = ""
        for _ in range(self.random.randint(1, 3)):
            if depth < 2 and self.random.random() < 0.25:
                text += "[" + " ,".join(self.conditions(depth + 1) for _ in range(self.random.randint(2, 3))) + " ]"
            else:
                text += self.condition()
        return text

    def output(self):
        r = self.random
        kinds = [
            lambda: f"{r.choice(['OTE', 'OTL', 'OTU'])}({r.choice(BOOLS)})",
            lambda: f"{r.choice(['ADD', 'SUB'])}({r.choice(NUMBERS)},{self.number()},{r.choice(NUMBERS)})",
            lambda: f"MOV({self.number()},{r.choice(NUMBERS)})",
            lambda: f"DIV({r.choice(NUMBERS)},{r.randint(1, 9)},{r.choice(NUMBERS)})",
            lambda: f"CPT({r.choice(NUMBERS)},{r.choice(NUMBERS)}*{r.randint(1, 9)}+({r.choice(NUMBERS)}-{r.randint(0, 9)}))",
            lambda: f"CLR({r.choice(NUMBERS)})",
        ]
        # A timer or counter belongs to one rung.
        if self.timers and r.random() < 0.3:
            return f"{r.choice(['TON', 'TOF'])}({self.timers.pop()},?,?)"
        if self.counters and r.random() < 0.3:
            return f"CTU({self.counters.pop()},?,?)"
        return r.choice(kinds)()

    def outputs(self):
        return "".join(self.output() for _ in range(self.random.randint(1, 2)))

    def rung(self):
        text = self.conditions() if self.random.random() < 0.9 else ""
        if text and self.storage and self.random.random() < 0.3:
            text += f"ONS({self.storage.pop()})"
        if self.random.random() < 0.3:
            legs = [(self.conditions(1) if self.random.random() < 0.8 else "") + self.outputs() for _ in range(2)]
            return text + "[" + " ,".join(legs) + " ];"
        return text + self.outputs() + ";"


def project(program):
    """The L5X file of a program."""

    def plain(name, kind):
        return (
            f'<Tag Name="{name}" TagType="Base" DataType="{kind}" Radix="Decimal" Constant="false" ExternalAccess="Read/Write">'
            f'<Data Format="Decorated"><DataValue DataType="{kind}" Radix="Decimal" Value="0"/></Data></Tag>'
        )

    def structure(name, kind, preset):
        members = "".join(
            f'<DataValueMember Name="{member}" DataType="{"DINT" if member in ("PRE", "ACC") else "BOOL"}" '
            f'Value="{preset if member == "PRE" else 0}"/>'
            for member in MEMBERS[kind]
        )
        return (
            f'<Tag Name="{name}" TagType="Base" DataType="{kind}" Constant="false" ExternalAccess="Read/Write"><Data Format="Decorated">'
            f'<Structure DataType="{kind}">{members}</Structure></Data></Tag>'
        )

    def routine(name, rungs):
        rows = "".join(f'<Rung Number="{n}" Type="N"><Text><![CDATA[{text}]]></Text></Rung>' for n, text in enumerate(rungs))
        return f'<Routine Name="{name}" Type="RLL"><RLLContent>{rows}</RLLContent></Routine>'

    tags = "".join(plain(name, "BOOL") for name in BOOLS + STORAGE) + "".join(plain(name, "DINT") for name in NUMBERS)
    for kind, names in (("TIMER", TIMERS), ("COUNTER", COUNTERS)):
        tags += "".join(structure(name, kind, preset) for name, preset in zip(names, PRESETS[kind]))
    return (
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>'
        '<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="33.00" TargetName="Rival" TargetType="Controller">'
        '<Controller Use="Target" Name="Rival"><DataTypes/><Tags>'
        '<Tag Name="Motion1" TagType="Base" DataType="MOTION_GROUP"><Data Format="MotionGroup"><MotionGroupParameters CoarseUpdatePeriod="10000"/></Data></Tag>'
        '<Tag Name="V" TagType="Base" DataType="AXIS_VIRTUAL"><Data Format="Axis"><AxisParameters/></Data></Tag>'
        f'{tags}</Tags><Programs><Program Name="Main" MainRoutineName="Go" Disabled="false"><Tags/><Routines>'
        f'{routine("Sub", program.sub)}{routine("Go", program.main)}</Routines></Program></Programs>'
        '<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="5" Watchdog="500"><ScheduledPrograms><ScheduledProgram Name="Main"/></ScheduledPrograms>'
        "</Task></Tasks></Controller></RSLogix5000Content>"
    )


def leaves():
    """Every value that is compared."""
    yield from BOOLS
    yield from STORAGE
    yield from NUMBERS
    for kind, names in (("TIMER", TIMERS), ("COUNTER", COUNTERS)):
        yield from (f"{name}.{member}" for name in names for member in MEMBERS[kind])


# Reads lines `all values`, `inputs` and answers each with all values after a scan.
HARNESS = """
#include <stdio.h>
int main() {
    long value;
%s
    while (1) {
%s
        Go();
%s
        printf("\\n");
        fflush(stdout);
    }
}
"""


def translated(l5x2c, folder):
    """The program of l5x2c, and the compiler's."""
    text = folder / "rival.c"
    run = [sys.executable, "l5x2c.py", str(folder / "Rival.L5X"), str(text), "--scan_time", str(SCAN_MS)]
    told = subprocess.run(run, cwd=l5x2c, check=True, capture_output=True, text=True)
    if "Syntax Error" in text.read_text():
        raise SystemExit(f"l5x2c cannot read a rung: {told.stderr}")
    read = '    if (scanf("%ld", &value) != 1) return 0; {name} = value;'
    harness = HARNESS % (
        "\n".join(read.replace("{name}", name) for name in leaves()),
        "\n".join("    " + read.replace("{name}", name) for name in BOOLS[:8]),
        "\n".join(f'        printf("%ld ", (long){name});' for name in leaves()),
    )
    # `and` and `or` are functions there.
    text.write_text(text.read_text().replace("/***************************************************\n/*", "/*\n") + harness)
    # Sums of DINTs wrap around, as in a controller.
    subprocess.run(["cc", "-w", "-O1", "-fwrapv", "-o", folder / "rival", text, "-lm"], check=True)
    return folder / "rival"


def differs(program, l5x2c, scans):
    """The first difference of a program: scan, tag, and both values."""
    inputs = random.Random(program.random.random())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "Rival.L5X").write_text(project(program))
        cell = arcline.Cell(str(folder / "Rival.L5X"))
        rival = subprocess.Popen([translated(l5x2c, folder)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        rival.stdin.write(" ".join(str(int(cell[name])) for name in leaves()) + "\n")
        states = [0] * 8
        for scan in range(scans):
            states = [1 - state if inputs.random() < 0.2 else state for state in states]
            for name, state in zip(BOOLS, states):
                cell[name] = bool(state)
            rival.stdin.write(" ".join(map(str, states)) + "\n")
            rival.stdin.flush()
            cell.step(1)
            answer = rival.stdout.readline().split()
            for name, theirs in zip(leaves(), answer, strict=True):
                if int(cell[name]) != int(theirs):
                    rival.kill()
                    return scan, name, int(cell[name]), int(theirs)
        rival.stdin.close()
        rival.wait()
    return None


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("l5x2c", type=pathlib.Path, help="the folder of l5x2c")
    arguments.add_argument("--programs", type=int, default=300)
    arguments.add_argument("--scans", type=int, default=100)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--known", action="store_true", help="count what is known to differ")
    given = arguments.parse_args()
    seeds = range(given.seed, given.seed + given.programs)
    if given.known:
        for known in KNOWN:
            found = [differs(Program(seed, known), given.l5x2c, given.scans) for seed in seeds]
            print(f"{known}: {sum(one is not None for one in found)} of {given.programs} programs differ")
        return 0
    wrong = 0
    for seed in seeds:
        program = Program(seed)
        difference = differs(program, given.l5x2c, given.scans)
        if difference:
            wrong += 1
            scan, name, ours, theirs = difference
            print(f"seed {seed}, scan {scan}: {name} is {ours} in Arcline and {theirs} in l5x2c")
            print("\n".join(["  Sub:", *("    " + rung for rung in program.sub), "  Go:", *("    " + rung for rung in program.main)]))
    print(f"{given.programs - wrong} of {given.programs} programs have the same {sum(1 for _ in leaves())} values in each of {given.scans} scans")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
