"""The tags of a controller's program by an unmodified pycomm3 while the program runs: pycomm3_program.py HOST:PORT."""

import sys

from pycomm3 import LogixDriver
from checks import *

server = sys.argv[1]

with LogixDriver(server) as plc:
    equal("the programs", sorted(plc.info["programs"]), ["Main"])
    equal("its routines", sorted(plc.info["programs"]["Main"]["routines"]), ["Count", "Go"])
    equal("the tasks", sorted(plc.info["tasks"]), ["Fast"])
    equal("the mode", plc.get_plc_info()["keyswitch"], "REMOTE RUN")
    for tag, data_type in [("Batch", "Recipe"), ("Program:Main.Sum", "Adder"), ("Program:Main.Settle", "TIMER"),
                           ("Program:Main.Move", "MOTION_INSTRUCTION")]:
        equal(f"{tag} in the list", plc.tags[tag]["data_type_name"], data_type)
    equal("a constant", plc.tags["Fixed"]["external_access"], "Read Only")
    holds("a tag that no client sees", "Secret" not in plc.tags)
    equal("a structure", plc.read("Batch").value, {"Steps": [4, 5, 6], "Speed": 80.0})
    holds("write a structure", plc.write("Batch", {"Steps": [1, 9, 3], "Speed": 60.0}))
    equal("an alias", plc.read("Middle").value, 9)
    sum_before = plc.read("Program:Main.Sum").value
    equal("an instance", (sum_before["EnableIn"], sum_before["Total"]), (False, 0))
    first = plc.read("Program:Main.Scans").value
    holds("write", plc.write(("Target", 4.0), ("Start", True)))
    eventually("the end", lambda: plc.read("Done").value)
    equal("the position", plc.read("X.CommandPosition").value, 4.0)
    eventually("the sum", lambda: plc.read("Program:Main.Twice").value)
    equal("the total", [plc.read(tag).value for tag in ("Program:Main.Sum.Total", "Program:Main.Twice")], [9, 18])
    timer = plc.read("Program:Main.Settle").value
    equal("the timer", (timer["PRE"], timer["DN"], timer["ACC"] >= 50), (50, True, True))
    holds("scans", plc.read("Program:Main.Scans").value > first)
    holds("write to an instance", plc.write("Program:Main.Sum.Total", 100))
    eventually("the program takes it", lambda: plc.read("Program:Main.Twice").value == 200)
