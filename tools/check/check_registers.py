#!/usr/bin/env python3
"""Compares every register address, offset, bit field, pad and width in firmware/port/imxrt1062 with a machine-readable
description of the chip. The description is the Rust crate imxrt-ral, which cargo fetches into build/registers
(register_description.py). Prints TAP.

If all values agree, the script writes the digests of the port's files to firmware/port/imxrt1062/registers.checked.
`make test` compares the stored digests with the files (test_registers.py). The test test_registers.py needs no network,
and it fails if a file was changed after the last check. The document docs/porting.md lists the registers that the crate
does not describe, under "What no script has checked"."""

import os
import re

import register_description
import register_stamp
import tree

PORT = "firmware/port/imxrt1062/"
HEADER = PORT + "imxrt1062_registers.h"
MODEL = "hil_tests/rt1062/registers.h"  # of the emulated board: docs/rt1062.md
ACCESS = re.compile(r"\bR(16|32)\(\s*([^,()]+(?:\([^()]*\))?[^,()]*),\s*([A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+)")
HEADER_OF_MACROS = ("CRN_", "R16", "R32", "LOAD", "STORE", "BITS", "MASK", "SET_FIELD")


def numbers(text):
    return tuple(int(word.strip().rstrip("u"), 0) for word in text.split(","))


def module_of(instance):
    return instance.rstrip("0123456789") if instance not in ("DCDC",) else instance


class Header:
    """Sorts the lines of the port's C header by kind, and adds lines that cannot be interpreted to `findings`."""

    def __init__(self, text):
        self.bases, self.lines, self.findings = {}, [], []
        for number, line in enumerate(text.splitlines(), 1):
            words = line.split(None, 2)
            if not line.startswith("#define ") or words[1].startswith(HEADER_OF_MACROS):
                continue
            try:
                value = numbers(words[2])
            except (ValueError, IndexError):
                self.findings.append("%s:%d: not numbers: %s" % (HEADER, number, line))
                continue
            if words[1].startswith("BASE_"):
                self.bases[words[1][5:]] = value[0]
            self.lines.append((number, words[1], value))

    def instance(self, name):
        """Finds the peripheral instances whose module name is the beginning of `name`, and returns the one with the
        longest module name."""
        found = [i for i in self.bases if name.startswith(module_of(i) + "_")]
        return max(found, key=lambda i: len(module_of(i))) if found else None


def register_names(name):
    """A register `SMVAL3_0` of the C header is SMVAL3[0] in the description, if SMVAL3 is an array there."""
    match = re.match(r"(.*)_(\d+)$", name)
    return [name] + (["%s[%s]" % match.groups()] if match else [])


def find_register(block, name):
    return next((n for n in register_names(name) if n in block.registers), None)


def stride(block, name):
    for first, second in ((name + "[0]", name + "[1]"), (name + "0", name + "1")):
        if first in block.registers and second in block.registers:
            return block.registers[second][0] - block.registers[first][0]
    return None


def check_pad(iomux, name, value):
    """Reads the header's lines PAD_<pad>_<function> (mux, mode, pad register) and DAISY_<input>_<pad> (register,
    value)."""
    kind, rest = name.split("_", 1)
    if kind == "PAD":
        for pad in (rest[: m.start()] for m in re.finditer("_", rest)):
            mux, control = "SW_MUX_CTL_PAD_GPIO_" + pad, "SW_PAD_CTL_PAD_GPIO_" + pad
            if mux in iomux.registers:
                said = iomux.values[mux]["MUX_MODE"].get(value[1], "")
                right = (iomux.registers[mux][0], value[1], iomux.registers[control][0])
                port = re.search(r"port: (\w+)", said)
                return value == right and port is not None and port.group(1) == rest[len(pad) + 1 :]
    else:
        for entry in (rest[: m.start()] for m in re.finditer("_", rest)):
            register = entry + "_SELECT_INPUT"
            if register in iomux.registers:
                said = iomux.values[register]["DAISY"].get(value[1], "")
                return value[0] == iomux.registers[register][0] and re.search(
                    r"Pad: ?GPIO_%s for" % rest[len(entry) + 1 :], said
                )
    return False


def check_line(header, description, name, value):
    """Returns None if the header's value agrees with the chip's description, and otherwise a text about the
    difference."""
    if name.startswith("BASE_"):
        right = description.bases.get(name[5:])
        return None if right == value[0] else "the description has %s" % (right if right is None else hex(right))
    if name.startswith(("PAD_", "DAISY_")):
        return None if check_pad(description.block("IOMUXC"), name, value) else "the description does not say so"
    instance = header.instance(name)
    if instance is None:
        return "no BASE_ line of its module"
    block, rest = description.block(instance), name[len(module_of(instance)) + 1 :]
    if rest.startswith("STRIDE_"):
        right = stride(block, rest[7:])
        return None if right == value[0] else "the description has %s" % right
    if len(value) == 1:
        register = find_register(block, rest)
        right = block.registers[register][0] if register else None
        return None if right == value[0] else "the description has %s" % (right if right is None else hex(right))
    for split in (m.start() for m in re.finditer("_", rest)):
        register = find_register(block, rest[:split])
        field = block.fields.get(register.split("[")[0], {}).get(rest[split + 1 :]) if register else None
        if field is not None:
            return None if field == value else "the description has %d, %d" % field
    return "the description has no such field"


def check_header(text, description):
    header = Header(text)
    yield from header.findings
    for number, name, value in header.lines:
        wrong = check_line(header, description, name, value)
        if wrong:
            yield "%s:%d: %s: %s" % (HEADER, number, name, wrong)


def check_access(path, text, header, description):
    """Checks that the code accesses each register in the register's own width, and at a base address of its own
    module."""
    for match in ACCESS.finditer(tree.code_only(text)):
        bits, base, name = int(match.group(1)), match.group(2).strip(), match.group(3)
        place = "%s:%d" % (path, tree.line_of(text, match.start()))
        instance = header.instance(name)
        block = description.block(instance) if instance else None
        register = find_register(block, name[len(module_of(instance)) + 1 :]) if block else None
        if register is None:
            yield "%s: %s is no register of %s" % (place, name, HEADER)
        elif block.registers[register][1] != bits:
            yield "%s: %s has %d bits, and is used with %d" % (place, name, block.registers[register][1], bits)
        elif base.startswith("BASE_") and module_of(base[5:]) != module_of(instance):
            yield "%s: %s is used with %s" % (place, name, base)


def used_names(text, sources):
    """Checks that the code uses every name of the C header, because this header should contain only the registers that
    the port needs."""
    code = " ".join(tree.TOKENS.sub(tree.blank, source) for source in sources)
    words = set(re.findall(r"\w+", code)) | {
        "IOMUXC_SW_PAD_CTL_PAD_GPIO_EMC_24_" + f for f in re.findall(r"PAD_FIELD\((\w+)", code)
    }
    for number, name, _ in Header(text).lines:
        if name not in words:
            yield "%s:%d: %s is not used" % (HEADER, number, name)


def self_test(report, description, text):
    def broken(old, new):
        return list(check_header(text.replace(old, new, 1), description)) if old in text else []

    report.catches("a wrong base address is caught", broken("BASE_CCM 0x400fc000u", "BASE_CCM 0x400fd000u"))
    report.catches("a wrong offset is caught", broken("CCM_CBCDR 0x14u", "CCM_CBCDR 0x18u"))
    report.catches("a wrong field is caught", broken("CCM_CBCDR_AHB_PODF 10, 3", "CCM_CBCDR_AHB_PODF 10, 2"))
    report.catches("an unknown register is caught", broken("CCM_CBCDR 0x14u", "CCM_CBCDX 0x14u"))
    report.catches("a wrong stride is caught", broken("PWM_STRIDE_SMCTRL 0x60u", "PWM_STRIDE_SMCTRL 0x40u"))
    report.catches("a wrong mux mode is caught", broken("XBAR1_INOUT06 0x24u, 3,", "XBAR1_INOUT06 0x24u, 1,"))
    report.catches(
        "a wrong input selection is caught",
        broken("DAISY_XBAR1_IN14_B1_00 0x644u, 1", "DAISY_XBAR1_IN14_B1_00 0x644u, 0"),
    )
    header = Header(text)
    report.catches(
        "a 16-bit register used with 32 bits is caught",
        check_access("x.c", "R32(BASE_WDOG1, WDOG_WCR) = 0;", header, description),
    )
    report.catches(
        "a register at another module's base is caught",
        check_access("x.c", "R16(BASE_ENC1, WDOG_WCR) = 0;", header, description),
    )
    report.catches("a name that is not used is caught", used_names(text, ["BASE_CCM"]))


def main():
    report = tree.Report()
    text = tree.read(HEADER)
    try:
        description = register_description.Description(
            register_description.fetch(os.path.join(tree.ROOT, "build", "registers"))
        )
    except register_description.CannotRead as problem:
        report.check("the description of the i.MX RT1062 can be read", [str(problem)])
        report.end()
        return
    self_test(report, description, text)
    paths = [path for path in tree.files(".c", ".h") if path.startswith(PORT) and path != HEADER]
    sources = {path: tree.read(path) for path in paths}
    header = Header(text)
    report.check(
        "%d lines of the register header are what the chip's description says" % len(header.lines),
        check_header(text, description),
    )
    report.check(
        "every register is used in its own width, at its own module's base",
        (f for path in paths for f in check_access(path, sources[path], header, description)),
    )
    report.check("every register of the header is used", used_names(text, sources.values()))
    bases = "".join(line for line in text.splitlines(True) if line.startswith("#define BASE_"))
    report.check(
        "the emulated board's further registers (%s) are what the chip's description says" % MODEL,
        check_header(bases + tree.read(MODEL), description),
    )
    if report.failed == 0:
        register_stamp.write("%s %s" % (register_description.CRATE, register_description.VERSION))
        print("# written: " + register_stamp.STAMP)
    report.end()


if __name__ == "__main__":
    main()
