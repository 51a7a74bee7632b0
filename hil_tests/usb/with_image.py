#!/usr/bin/env python3
"""Starts the device's firmware image on the emulated Cortex-M7, and runs a command while the device runs.

  with_image.py IMAGE COMMAND ARGUMENT...

In the arguments, `{mailbox}` is replaced by the location of the USB tokens in the emulator's memory (FILE:OFFSET), as
`bridge` and `mock_bus` expect it. The device has no rig, and the emulator provides its clock ticks of 1 ms. The exit
code is that of the command, or 1 if the device did not start. No process outlives the command."""

import os
import struct
import subprocess
import sys
import tempfile
import time

MEMORY_BYTES = 16 << 20
MAGIC = 0x42535553  # shared/mailbox/mailbox.h
START_SECONDS = 10


def wait_for_device(memory, emulator):
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end and emulator.poll() is None:
        with open(memory, "rb") as file:
            magic, _, _, attached = struct.unpack("<IIII", file.read(16))
        if magic == MAGIC and attached == 1:
            return True
        time.sleep(0.01)
    return False


def main():
    if len(sys.argv) < 3:
        print("usage: with_image.py IMAGE COMMAND ARGUMENT...", file=sys.stderr)
        return 2
    shared = "/dev/shm" if os.path.isdir("/dev/shm") else None
    with tempfile.TemporaryDirectory(prefix="cournand_", dir=shared) as folder:
        memory = os.path.join(folder, "memory")
        with open(memory, "wb") as file:
            file.truncate(MEMORY_BYTES)
        emulator = subprocess.Popen(
            [
                "qemu-system-arm",
                "-M",
                "mps2-an500,memory-backend=ram",
                "-object",
                "memory-backend-file,id=ram,size=%d,mem-path=%s,share=on" % (MEMORY_BYTES, memory),
                "-nodefaults",
                "-display",
                "none",
                "-kernel",
                sys.argv[1],
            ],
            stdin=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            if not wait_for_device(memory, emulator):
                print("with_image: the device did not start within %d s" % START_SECONDS, file=sys.stderr)
                return 1
            return subprocess.run(
                [word.replace("{mailbox}", memory + ":0") for word in sys.argv[2:]], check=False
            ).returncode
        finally:
            emulator.kill()
            emulator.wait()


if __name__ == "__main__":
    sys.exit(main())
