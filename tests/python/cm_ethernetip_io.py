"""Exchanges data in cycles with an Arcline server by an unmodified cm-ethernetip: cm_ethernetip_io.py HOST:PORT.

The server has the default machine, and UDP port 2222 of the address; the scanner sends from any port of the same host.
"""

import asyncio
import struct
import sys

from ethernetip.protocol.eip_scanner import EipScanner
from ethernetip.protocol.forward_open_config import ForwardOpenConfig
from checks import *

host, port = sys.argv[1].split(":")

# Bytes of the assemblies (docs/IO.md): four coordinate systems, seven axes.
INPUT, OUTPUT = 12 + 4 * 24 + 7 * 20, 4 + 4 * 4
STATUS, ECHO, OVERRIDE = 4, 8, 12 + 8
OWNED, RUN = 1, 2
# An interval that is confirmed however busy the machine is, µs.
RPI = 40_000
# The size that this scanner puts into a Forward Open leaves out the sequence count.
COUNT = 2


async def until(what, look, seconds=20.0):
    deadline = time.monotonic() + seconds
    while not look():
        if time.monotonic() > deadline:
            sys.exit(f"FAILED {what}: not within {seconds} s")
        await asyncio.sleep(0.005)
    print(f"ok  {what}")


async def main():
    async with EipScanner() as scanner:
        await scanner.connect(host, int(port))
        config = ForwardOpenConfig(consumed_assembly=150, produced_assembly=100, config_assembly=151,
                                   consumed_size=OUTPUT + COUNT, produced_size=INPUT + COUNT, rpi=RPI)
        connection = await scanner.forward_open(config)
        await until("inputs come", lambda: connection.receive_count > 100)
        await until("it owns the outputs, in run", lambda: connection.read_dint(STATUS) == OWNED | RUN)
        equal("size of the inputs", len(connection.produced_data) - COUNT, INPUT)

        connection.set_consumed_data(struct.pack("<I4f", 8, 50.0, 60.0, 70.0, 80.0))
        await until("the command word comes back", lambda: connection.read_dint(ECHO) == 8)
        override = lambda place: struct.unpack_from("<f", connection.produced_data, OVERRIDE + 24 * place)[0]
        await until("the feed overrides", lambda: [override(place) for place in range(4)] == [50.0, 60.0, 70.0, 80.0])

        try:
            await scanner.forward_open(config)
            sys.exit("FAILED a second owner: it was let in")
        except RuntimeError as error:
            holds("a second owner is refused", "0x01" in str(error), error)

        await connection.close()
        received = connection.receive_count
        await asyncio.sleep(0.2)
        equal("nothing comes after the close", connection.receive_count, received)
        connection = await scanner.forward_open(config)
        await until("it opens again", lambda: connection.receive_count > 2)
        await connection.close()


asyncio.run(main())
