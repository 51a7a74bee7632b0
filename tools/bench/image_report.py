#!/usr/bin/env python3
"""Measures the code size, RAM and worst stack of a device's firmware image, and checks that it contains no soft-float
code, divide helper or heap.

  image_report.py --build build --port mps2_an500

The worst stack is the largest sum of stack bytes along a path from main() through the compiler's call graph, plus the
stack of one exception and its handler. Calls through function pointers reach only functions of the port, and this
program has a list of these functions. The exit code is 1 when RAM or stack exceed their limits, or when the image
contains a forbidden function.
"""

import argparse
import os
import sys

import budget

RAM_MAX_BYTES = 512 * 1024  # without scenes
STACK_MAX_BYTES = 16 * 1024
# These functions are in each port's tables (its main.c, and its USB controller). The USB stack calls the app by
# address while it polls. The stack depth of these calls is added once, even if the deepest path does not include them.
BY_ADDRESS = {
    "mps2_an500": ("transmit", "transmit_room", "rig_inputs_read", "rig_outputs_write", "now_us"),
    "imxrt1062": (
        "crn_rig_usb_transmit",
        "crn_rig_usb_room",
        "rig_inputs",
        "rig_outputs",
        "clocks_now_us",
        "udc_connect",
        "udc_set_address",
        "udc_open",
        "udc_close",
        "udc_arm",
        "udc_stall",
        "udc_test",
        "udc_poll",
    ),
}
EXCEPTION_BYTES = 32 + 4  # eight registers, aligned to 8


def symbols(image):
    """name -> (address, size or None)"""
    table = {}
    for line in budget.run(["arm-none-eabi-nm", "-S", image]).splitlines():
        words = line.split()
        table[words[-1]] = (int(words[0], 16), int(words[1], 16) if len(words) == 4 else None)
    return table


def sections(image):
    """name -> bytes"""
    rows = [line.split() for line in budget.run(["arm-none-eabi-size", "-A", image]).splitlines()]
    return {row[0]: int(row[1]) for row in rows if len(row) == 3 and row[1].isdigit()}


def stack_bytes(objects, port):
    loop, path = budget.worst_stack(objects, "main", BY_ADDRESS[port])
    usb, _ = budget.worst_stack(objects, "crn_rig_usb_poll", BY_ADDRESS[port])
    crash, _ = budget.worst_stack(objects, "crashed", BY_ADDRESS[port])
    return loop + usb + EXCEPTION_BYTES + crash, path


def report(image, objects, port):
    """Prints the report on the image and returns the errors."""
    size, names = sections(image), symbols(image)
    code = size.get(".boot", 0) + size.get(".text", 0) + size.get(".ARM.exidx", 0) + size.get(".data", 0)
    static = size.get(".data", 0) + size.get(".bss", 0) + size.get(".dma", 0)
    stack, path = stack_bytes(objects, port)
    left = names["stack_bytes"][0]
    print("%s" % image)
    print("  code and constants  %7d bytes" % code)
    print(
        "  RAM without scenes  %7d bytes: %d static (app %d) + %d stack at most"
        % (static + stack, static, names["app"][1], stack)
    )
    print("  near memory         %7d bytes" % size.get(".near", 0))
    print("  scene slots         %7d bytes" % size.get(".scenes", 0))
    print("  deepest calls       %s" % " > ".join(path))
    wrong = []
    if static + stack > RAM_MAX_BYTES:
        wrong.append("RAM is over %d bytes" % RAM_MAX_BYTES)
    if stack > min(STACK_MAX_BYTES, left):
        wrong.append("the stack may need %d bytes; %d are left, %d allowed" % (stack, left, STACK_MAX_BYTES))
    forbidden = budget.forbidden_symbols(image)
    if forbidden:
        wrong.append("the image holds " + ", ".join(forbidden))
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="folder of the build (default: build)")
    parser.add_argument("--port", choices=sorted(BY_ADDRESS), default="mps2_an500")
    options = parser.parse_args()
    try:
        image = os.path.join(options.build, "firmware", "cournand-%s.elf" % options.port)
        wrong = report(image, budget.image_objects(options.build, options.port), options.port)
    except budget.CannotMeasure as problem:
        wrong = [str(problem)]
    for text in wrong:
        print("  FAILED: %s" % text)
    if not wrong:
        print("  no soft-float, no divide helper, no heap")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
