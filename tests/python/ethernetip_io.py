"""Exchanges data in cycles with an Arcline server by an unmodified ethernetip: ethernetip_io.py HOST:PORT.

The server has the default machine, and UDP port 2222 of the address. The scanner says in item 0x8001 where it listens, and
sends an electronic key when it is given one.
"""

import struct
import sys

import ethernetip.ethernetip as scanner
from checks import *

host, port = sys.argv[1].split(":")
# The library knows no other port than 44818.
scanner.ENIP_TCP_PORT = int(port)

# Assemblies and their bytes (docs/IO.md): four coordinate systems, seven axes.
CONFIGURATION, INPUTS, OUTPUTS = 151, 100, 150
INPUT, OUTPUT = 12 + 4 * 24 + 7 * 20, 4 + 4 * 4
OWNED, RUN = 1, 2
# An interval that is confirmed however busy the machine is, ms.
RPI = 40
OWNERSHIP_CONFLICT, WRONG_DEVICE_TYPE = 0x0106, 0x0115


def word(inputs, place):
    """Of the inputs, which it shows as bits."""
    return sum(bool(bit) << number for number, bit in enumerate(inputs[8 * place:8 * place + 32]))


def real(inputs, place):
    return struct.unpack("<f", struct.pack("<I", word(inputs, place)))[0]


def explicit(device, connection):
    equal("UDP discovery", bytes(device.listIDUDP().product_name), b"Arcline demo")
    equal("TCP discovery", bytes(connection.listID().product_name), b"Arcline demo")
    equal("ListServices", bytes(connection.listServices().name_of_service).rstrip(b"\0"), b"Communications")
    equal("a session", connection.registerSession(), 0)
    equal("an attribute", connection.getAttrSingle(1, 1, 7), [0, b"\x0cArcline demo"])
    equal("over a route", connection.getAttrSingle(1, 1, 7, port=1, slot=0), [0, b"\x0cArcline demo"])
    equal("an attribute that is not there", connection.getAttrSingle(1, 1, 99)[0], 0x14)
    sizes = [struct.unpack("<H", connection.getAttrSingle(4, instance, 4)[1])[0] for instance in (INPUTS, OUTPUTS)]
    equal("sizes of the assemblies", sizes, [INPUT, OUTPUT])


def cyclic(device, connection):
    inputs = device.registerAssembly(device.ENIP_IO_TYPE_INPUT, INPUT, INPUTS, connection)
    outputs = device.registerAssembly(device.ENIP_IO_TYPE_OUTPUT, OUTPUT, OUTPUTS, connection)
    device.startIO(udp_port=0)

    def forward_open(of=connection, **how):
        return of.sendFwdOpenReq(INPUTS, OUTPUTS, CONFIGURATION, torpi=RPI, otrpi=RPI,
                                 originator_udp_port=device.originator_udp_port, **how)

    equal("Forward Open", forward_open(), 0)
    connection.produce()
    first = eventually("inputs come", lambda: word(inputs, 0))
    eventually("and go on", lambda: word(inputs, 0) > first + 1000)
    eventually("it owns the outputs, in run", lambda: word(inputs, 4) == OWNED | RUN)
    data = struct.pack("<I4f", 8, 50.0, 60.0, 70.0, 80.0)
    outputs[:] = [bool(byte >> bit & 1) for byte in data for bit in range(8)]
    eventually("the command word comes back", lambda: word(inputs, 8) == 8)
    overrides = lambda: [real(inputs, 12 + 8 + 24 * place) for place in range(4)]
    eventually("the feed overrides", lambda: overrides() == [50.0, 60.0, 70.0, 80.0])

    other = device.explicit_conn(host)
    # The library numbers the connections of each session from 1.
    other.conn_serial_num = 100
    equal("another session", other.registerSession(), 0)
    refused = forward_open(other, inputsz=INPUT, outputsz=OUTPUT)
    equal("a second owner is refused", refused, OWNERSHIP_CONFLICT)
    other.unregisterSession()

    connection.stopProduce()
    equal("Forward Close", connection.sendFwdCloseReq(INPUTS, OUTPUTS, CONFIGURATION), 0)
    # The datagrams under way have arrived.
    time.sleep(0.2)
    last = word(inputs, 0)
    time.sleep(0.2)
    equal("nothing comes after the close", word(inputs, 0), last)

    refused = forward_open(keyring=scanner.KeyRing(devicetype=0x0C))
    equal("another device's key is refused", refused, WRONG_DEVICE_TYPE)
    equal("its own key is not", forward_open(keyring=scanner.KeyRing(devicetype=0x0E)), 0)
    eventually("inputs again", lambda: word(inputs, 0) > last)
    equal("Forward Close again", connection.sendFwdCloseReq(INPUTS, OUTPUTS, CONFIGURATION), 0)


device = scanner.EtherNetIP(host)
connection = device.explicit_conn(host)
try:
    explicit(device, connection)
    cyclic(device, connection)
finally:
    # Its threads outlive the script.
    connection.stopProduce()
    device.stopIO()
connection.unregisterSession()
print("ethernetip: all as expected")
