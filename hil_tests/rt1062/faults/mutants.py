#!/usr/bin/env python3
"""Asks whether the tests of the chip's model notice a model that is wrong: docs/rt1062.md, "Mutants".

Every mutant changes one behaviour of one register: a field that reads 0, ones, or one more; a field that is
written so; a register that ignores what is written; a wrong reset value; a time that is a quarter or four times
what it should be. The list is made from the registers that the tests access. A mutant is noticed if a program
of the tests fails. Prints the survivors, and the share of the mutants that are noticed."""
import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../.."))
HEADERS = ["firmware/port/imxrt1062/imxrt1062_registers.h", "hil_tests/rt1062/registers.h"]
KINDS = ["none", "read_clear", "read_set", "read_flip", "read_more", "write_clear", "write_set", "write_more",
         "write_lost", "reset", "early", "late"]
RUNS_MAX_s = 120
# Stored words whose value after a reset is unknown (by the manual), or that are no register but a part of one.
NO_RESET_VALUE = ("FLEXSPI2_LUT", "MPU_RBAR", "PWM_SMINIT", "PWM_SMVAL")
INSTANCES = {"ENC": ["ENC1", "ENC2", "ENC3", "ENC4"], "TMR": ["TMR1", "TMR3"], "PWM": ["PWM2", "PWM3"],
             "ADC": ["ADC1", "ADC2"], "GPIO": ["GPIO1", "GPIO2", "GPIO3"], "USB": ["USB1"], "LPUART": ["LPUART6"],
             "FLEXSPI": ["FLEXSPI2"], "GPT": ["GPT1"], "WDOG": ["WDOG1"], "USBPHY": ["USBPHY1"],
             "PMU": ["CCM_ANALOG"], "XBARA": ["XBARA1"]}


def definitions():
    """Bases, registers (offset) and fields (shift, bits) of the two headers, by name."""
    bases, offsets, fields = {}, {}, {}
    for header in HEADERS:
        for line in open(os.path.join(ROOT, header), encoding="utf-8"):
            found = re.match(r"#define (\w+) (0x[0-9a-f]+)u?$", line)
            if found and found[1].startswith("BASE_"):
                bases[found[1][5:]] = int(found[2], 16)
            elif found and not found[1].startswith(("PAD_", "DAISY_")):
                offsets[found[1]] = int(found[2], 16)
            found = re.match(r"#define (\w+) (\d+), (\d+)$", line)
            if found:
                fields[found[1]] = (int(found[2]), int(found[3]))
    return bases, offsets, fields


def fields_by_address():
    """Named fields of every register's address; arrays of submodules and channels are spread out."""
    bases, offsets, fields = definitions()
    found = {}
    for name, offset in offsets.items():
        module = max((m for m in set(bases) | set(INSTANCES) if name.startswith(m + "_")), key=len, default=None)
        if module is None or "_STRIDE_" in name:
            continue
        own = [(f[len(name) + 1:], place) for f, place in fields.items() if f.startswith(name + "_")]
        stride = {"PWM": 0x60, "TMR": 0x20}.get(module, 0)
        is_array = name.endswith("_0") or (module == "TMR" and name[-1] == "0")
        steps = [i * stride for i in range(4)] if stride and is_array else [0]
        for instance in INSTANCES.get(module, [module]):
            for step in steps if instance in bases else []:
                address = bases[instance] + offset + step
                label = f"{instance}_{name[len(module) + 1:]}" + (f"[{step // stride}]" if step else "")
                there = found.setdefault(address, (label, []))
                there[1].extend(own)
    return found


def census(programs, environment):
    """Registers that the tests access: address -> [bytes, reads, writes, ones, zeros, ones and zeros written], and
    the number of words in which the chip stores what it was told."""
    with tempfile.NamedTemporaryFile("r", suffix=".census") as file:
        for program in programs:
            run = subprocess.run(program, cwd=ROOT, env={**environment, "RT_CENSUS": file.name},
                                 capture_output=True, check=False)
            if run.returncode != 0:
                sys.exit(f"mutants.py: {program[0]} fails without a mutant; run it alone")
        registers, stored = {}, {}
        for line in file:
            words = line.split()
            if words[0] == "word":
                stored[int(words[1])] = " ".join(words[2:])
                continue
            there = registers.setdefault(int(words[0], 16), [0] * 7)
            there[0] = int(words[1])
            there[1] += int(words[2])
            there[2] += int(words[3])
            for i in range(4):
                there[3 + i] |= int(words[4 + i], 16)
    return registers, stored


def label_of(address):
    for name, begin, size in (("IOMUXC", 0x401F8000, 0x4000), ("XBARA1", 0x403BC000, 0x4000),
                              ("core", 0xE0000000, 0x100000), ("FLEXSPI2_LUT", 0x402A4200, 0x100)):
        if begin <= address < begin + size:
            return f"{name}+0x{address - begin:x}"
    return f"0x{address:08x}"


def mutants_of(registers, words):
    """(kind, address, shift, bits, label): what can be wrong in what the tests reach."""
    named, list_ = fields_by_address(), []
    for address, (width, reads, writes, ones, zeros, set_, cleared) in sorted(registers.items()):
        label, fields = named.get(address, (label_of(address), []))
        if label.startswith("0x"):
            continue  # a test asks for a register that the model does not have
        for field, (shift, bits) in fields or [("", (0, 8 * width))]:
            mask = ((1 << bits) - 1) << shift
            name = f"{label} {field}".strip()
            choices = []
            if reads:
                choices += ["read_clear"] * bool(ones & mask) + ["read_set"] * bool(zeros & mask)
                choices += ["read_more"] * (bits > 1)
            if writes:
                choices += ["write_clear"] * bool(set_ & mask) + ["write_set"] * bool(cleared & mask)
                choices += ["write_more"] * (bits > 1)
            list_ += [(kind, address, shift, bits, name) for kind in choices]
        if writes:
            list_.append(("write_lost", address, 0, 8 * width, label))
    list_ += [("reset", number, 0, 1, f"word {number}, {part}") for number, part in words.items()
              if part not in NO_RESET_VALUE]
    list_ += [(kind, number, 0, 0, f"time {name}") for kind in ("early", "late")
              for number, name in enumerate(durations())]
    return list_


def durations():
    text = open(os.path.join(ROOT, "hil_tests/rt1062/mutant.h"), encoding="utf-8").read()
    return [name for name in re.findall(r"RT_TIME_(\w+)", text)]


def is_noticed(program, environment):
    """Runs a program until its first failure. One that does not end has noticed something, too."""
    run = subprocess.Popen(program, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                           text=True, errors="replace")
    timer = threading.Timer(RUNS_MAX_s, run.kill)
    timer.start()
    for line in run.stdout:
        if "FAILED" in line or line.startswith("not ok"):
            run.kill()
            break
    timer.cancel()
    return run.wait() != 0


def judge(mutant, programs, environment, survivors, lines):
    kind, address, shift, bits, label = mutant
    variable = f"{KINDS.index(kind)} {address:x} {shift} {bits}"
    shown = {**environment, "RT_MUTANT": variable}
    by = next((p[0] for p in programs if is_noticed(p, shown)), None)
    lines.append(f"{label}\t{kind}\t{os.path.basename(by) if by else 'nobody'}")
    if by is None:
        survivors.append(lines[-1])
        print(f'survives: {label}: {kind}   RT_MUTANT="{variable}"', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default=os.environ.get("BUILD", "build"))
    parser.add_argument("--count", type=int, default=0, help="so many, drawn from all; 0: all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--match", default="", help="only mutants whose line contains this")
    parser.add_argument("--tsv", default="out/hil_rt1062_mutants.tsv")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    tests = os.path.join(arguments.build, "test/hil_tests/rt1062/tests")
    image = os.path.join(arguments.build, "firmware/cournand-imxrt1062.elf")
    quick = ("words", "registers", "times", "pins", "fault")
    programs = [[f"{tests}/test_{name}"] for name in quick]
    programs += [[f"{arguments.build}/hil/hil_rt1062", "--image", image, "--boot", "--boot-ms", "60"]]
    programs += [[f"{tests}/{name}"] for name in ("test_image", "test_usb_bus", "../bench/tests/test_board")]
    programs = [p for p in programs if os.path.exists(os.path.join(ROOT, p[0]))]
    # Every chip has 17 MB of memory; keeping them between the tests of a program saves most of its time.
    keeps = "glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=4000000000"
    environment = {**os.environ, "BUILD": arguments.build, "GLIBC_TUNABLES": keeps}
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    mutants = mutants_of(*census(programs, environment))
    if arguments.count:
        mutants = random.Random(arguments.seed).sample(mutants, min(arguments.count, len(mutants)))
    mutants = [m for m in mutants if arguments.match in " ".join(map(str, m))]
    if arguments.list:
        print("\n".join(f"{m[4]}: {m[0]}" for m in mutants))
        print(len(mutants))
        return 0
    survivors, lines = [], []
    try:
        for mutant in mutants:
            judge(mutant, programs, environment, survivors, lines)
            if len(lines) % 25 == 0:
                print(f"{len(lines)} of {len(mutants)}, {len(survivors)} survive", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    share = 100 * (len(lines) - len(survivors)) / max(1, len(lines))
    figures = f"model.mutants\t{len(lines)}\nmodel.mutants_noticed_pct\t{share:.1f}"
    if arguments.tsv:
        path = os.path.join(ROOT, arguments.tsv)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write("behaviour\tmutant\tnoticed by\n" + "\n".join(lines) + "\n" + figures + "\n")
    print(figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
