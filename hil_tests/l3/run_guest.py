#!/usr/bin/env python3
"""Runs a command of level L3 in a virtual machine with Debian's kernel that has rigs on its USB.

  run_guest.py [options] (--here | --app | --mailbox FILE[:OFFSET])... -- COMMAND ARGUMENT...

QEMU emulates an x86-64 PC with a USB controller (xHCI or EHCI); for each device, a bridge connects the device to the PC
by usbredir. COMMAND runs in the guest in the current folder. The host's file tree is mounted read-only, so COMMAND can
run the programs of the build tree. The folder of --out is /mnt in the guest and is writable. This script prints the
output of COMMAND at once. The script's exit code is that of COMMAND, or 1 when a part of the test did not start or took
too long. No process outlives the deadline."""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import kernel

MEMORY_MB = 384


def qemu_command(options, folder, sockets):
    line = "console=ttyS0 quiet panic=-1 tsc=unstable no_timer_check cournand_script=" + os.path.join(folder, "script")
    vmlinux, initrd = kernel.prepare(options.kernel)
    command = [
        "qemu-system-x86_64",
        "-M",
        "pc",
        "-cpu",
        "max",
        "-m",
        str(MEMORY_MB),
        "-nodefaults",
        "-no-user-config",
        "-display",
        "none",
        "-serial",
        "stdio",
        "-no-reboot",
        "-kernel",
        vmlinux,
        "-initrd",
        initrd,
        "-append",
        line,
        "-fsdev",
        "local,id=host,path=/,security_model=none,readonly=on,multidevs=remap",
        "-device",
        "virtio-9p-pci,fsdev=host,mount_tag=host",
        "-fsdev",
        "local,id=out,path=%s,security_model=none" % (options.out or folder),
        "-device",
        "virtio-9p-pci,fsdev=out,mount_tag=out",
        "-device",
        {"xhci": "qemu-xhci", "ehci": "usb-ehci"}[options.controller] + ",id=usb",
    ]
    for i, socket in enumerate(sockets):
        command += ["-chardev", "socket,id=device%d,path=%s" % (i, socket)]
        command += ["-device", "usb-redir,bus=usb.0,chardev=device%d" % i]
    if options.channel:
        command += [
            "-device",
            "virtio-serial-pci",
            "-chardev",
            "socket,id=channel,path=" + options.channel,
            "-device",
            "virtserialport,chardev=channel",
        ]
    return command


def wait_for(path, process, seconds):
    end = time.monotonic() + seconds
    while not os.path.exists(path):
        if process.poll() is not None or time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def stop(process):
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(2)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def write_script(path, command):
    with open(path, "w", encoding="utf-8") as file:
        file.write("cd %s && exec %s\n" % (shlex.quote(os.getcwd()), " ".join(shlex.quote(word) for word in command)))


def watch(guest, deadline):
    """Prints the command's output and returns its exit code, or None if the guest did not start the command."""
    late = threading.Timer(max(deadline - time.monotonic(), 0), guest.kill)
    late.start()
    code = None
    for line in guest.stdout:
        text = line.decode("utf-8", "replace").replace("\r", "").rstrip("\n")
        ended = re.match(r"guest: exit (\d+)$", text)
        if ended:
            code = int(ended.group(1))
        elif not re.match(r"guest: up |\[ *[0-9.]+\] (reboot|random)", text):
            print(text, flush=True)
    guest.wait()
    late.cancel()
    return code


def run_guest(options, folder):
    deadline = time.monotonic() + options.seconds
    write_script(os.path.join(folder, "script"), options.command)
    sockets = [os.path.join(folder, "usb%d" % i) for i in range(len(options.devices))]
    bridges, guest = [], None
    try:
        for socket, device in zip(sockets, options.devices):
            bridges.append(subprocess.Popen([options.bridge, socket] + ["--full-speed"] * options.full_speed + device))
        for socket, bridge in zip(sockets, bridges):
            if not wait_for(socket, bridge, 5):
                print("run_guest: the bridge did not start", file=sys.stderr)
                return 1
        guest = subprocess.Popen(
            qemu_command(options, folder, sockets),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        code = watch(guest, deadline)
        if code is None:
            print(
                "run_guest: the guest ended, or was ended after %d s, without an exit code" % options.seconds,
                file=sys.stderr,
            )
            return 1
        for bridge in bridges:
            try:
                bridge.wait(2)
            except subprocess.TimeoutExpired:
                pass
        return code or (1 if any(bridge.returncode for bridge in bridges) else 0)
    finally:
        for process in bridges + ([guest] if guest else []):
            stop(process)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bridge", default="build/hil/bridge", help="default: build/hil/bridge")
    parser.add_argument(
        "--kernel", default="build/hil/kernel", help="folder of vmlinux and initrd (default: build/hil/kernel)"
    )
    parser.add_argument("--seconds", type=int, default=60, help="deadline (default: 60)")
    parser.add_argument("--out", metavar="FOLDER", help="what the guest may write into")
    parser.add_argument("--controller", choices=["xhci", "ehci"], default="xhci", help="of the PC (default: xhci)")
    parser.add_argument("--full-speed", action="store_true", help="the devices' cables carry 12 Mbit/s only")
    parser.add_argument("--channel", metavar="SOCKET", help="what the guest's /dev/vport0p1 talks to")
    parser.add_argument(
        "--here", dest="devices", action="append_const", const=["--here"], help="the loop-back rig inside the bridge"
    )
    parser.add_argument(
        "--app",
        dest="devices",
        action="append",
        nargs="?",
        const=["--app"],
        metavar="SERIAL",
        type=lambda serial: ["--app=" + serial],
        help="the whole app inside the bridge",
    )
    parser.add_argument(
        "--mailbox",
        dest="devices",
        action="append",
        type=lambda place: ["--mailbox", place],
        metavar="FILE[:OFFSET]",
        help="a mailbox in shared memory",
    )
    parser.add_argument("command", nargs="+")
    options = parser.parse_args(arguments)
    if not options.devices:
        parser.error("name a device: --here, --app or --mailbox")
    return options


def main():
    options = parse(sys.argv[1:])
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        code = run_guest(options, folder)
    print("#- boot to verdict %.1f s" % (time.monotonic() - begin))
    return code


if __name__ == "__main__":
    sys.exit(main())
