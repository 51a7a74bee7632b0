#!/usr/bin/env python3
"""Writes the files of a simulated gamepad for umockdev: the device, its replies to the system calls by which GLFW reads
it, and the actions of its user. The sizes in the gamepad's replies are those that GLFW 3.3 requests. The simulated
user presses the right trigger and pushes the right stick forward soon after the program has opened the gamepad, and
keeps both so.

usage: gamepad.py NAME    writes NAME.umockdev, NAME.ioctl and NAME.evemu"""

import struct
import sys

KEYS = [0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13A, 0x13B, 0x13C, 0x13D, 0x13E]
STICKS, TRIGGERS, CROSS = (0, 1, 3, 4), (2, 5), (16, 17)
DEVICE = """\
P: /devices/virtual/input/input5
E: SUBSYSTEM=input
E: PRODUCT=3/45e/28e/110
E: NAME="Xbox 360 pad"
A: name=Xbox 360 pad
A: id/bustype=0003
A: id/vendor=045e
A: id/product=028e
A: id/version=0110
A: capabilities/ev=20000b
A: capabilities/key=7cdb000000000000 0 0 0 0
A: capabilities/abs=3003f
A: capabilities/rel=0
A: properties=0

P: /devices/virtual/input/input5/event5
N: input/event5
E: SUBSYSTEM=input
E: DEVNAME=/dev/input/event5
E: MAJOR=13
E: MINOR=69
"""
USER = "E: 0.300000 0003 0005 255\nE: 0.500000 0003 0004 -32768\n"


def bits(size, places):
    mask = bytearray(size)
    for place in places:
        mask[place // 8] |= 1 << place % 8
    return mask.hex().upper()


def replies():
    yield "@DEV /dev/input/event5"
    yield "EVIOCGBIT(0) 4 " + bits(4, [0, 1, 3])
    yield "EVIOCGBIT(1) 96 " + bits(96, KEYS)
    yield "EVIOCGBIT(3) 8 " + bits(8, STICKS + TRIGGERS + CROSS)
    yield "EVIOCGID 0 " + struct.pack("<4H", 3, 0x45E, 0x28E, 0x110).hex().upper()
    yield "EVIOCGNAME 13 " + b"Xbox 360 pad\0".ljust(256, b"\0").hex().upper()
    for axis in sorted(STICKS + TRIGGERS + CROSS):
        low, high = (-32768, 32767) if axis in STICKS else (0, 255) if axis in TRIGGERS else (-1, 1)
        yield "EVIOCGABS(%d) 0 " % axis + struct.pack("<6i", 0, low, high, 0, 0, 0).hex().upper()


def main():
    for ending, text in (("umockdev", DEVICE), ("ioctl", "\n".join(replies()) + "\n"), ("evemu", USER)):
        with open(sys.argv[1] + "." + ending, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()
