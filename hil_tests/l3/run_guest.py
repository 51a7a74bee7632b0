#!/usr/bin/env python3
"""Level L3: runs shell commands in a virtual machine with Debian's kernel that has the device on its USB.

  run_guest.py [--bridge PROGRAM] [--kernel FOLDER] [--seconds N] (--here | --app | --mailbox FILE[:OFFSET]) SCRIPT

QEMU emulates an x86-64 PC with an xHCI controller; the bridge hands it the device by usbredir. SCRIPT, a file below the
current folder, is run by sh in the guest, with the host's file tree mounted read-only, so it runs the very programs of the
build tree. Its output is printed; the exit code is its own, or 1 when something did not come up or took too long. Nothing
outlives the deadline."""
import argparse
import os
import re
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import kernel

MEMORY_MB = 384


def qemu_command(vmlinux, initrd, socket, script):
    line = "console=ttyS0 quiet panic=-1 tsc=unstable no_timer_check seldinger_folder=%s seldinger_command=%s" % (os.getcwd(), script)
    return ["qemu-system-x86_64", "-M", "pc", "-cpu", "max", "-m", str(MEMORY_MB), "-nodefaults", "-no-user-config", "-display", "none",
            "-serial", "stdio", "-no-reboot", "-kernel", vmlinux, "-initrd", initrd, "-append", line,
            "-fsdev", "local,id=host,path=/,security_model=none,readonly=on,multidevs=remap",
            "-device", "virtio-9p-pci,fsdev=host,mount_tag=host",
            "-device", "qemu-xhci", "-chardev", "socket,id=device,path=" + socket, "-device", "usb-redir,chardev=device"]


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


def run_guest(options, script):
    """(exit code, output) of the script; a reason instead of output when the guest did not come that far."""
    vmlinux, initrd = kernel.prepare(options.kernel)
    device = ["--mailbox", options.mailbox] if options.mailbox else ["--app" if options.app else "--here"]
    with tempfile.TemporaryDirectory() as folder:
        socket = os.path.join(folder, "usb")
        bridge = subprocess.Popen([options.bridge, socket] + device)
        try:
            if not wait_for(socket, bridge, 5):
                return 1, "the bridge did not start"
            done = subprocess.run(qemu_command(vmlinux, initrd, socket, script), stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=options.seconds, check=False)
            text = done.stdout.decode("utf-8", "replace").replace("\r", "")
        except subprocess.TimeoutExpired as late:
            text = (late.stdout or b"").decode("utf-8", "replace").replace("\r", "")
            return 1, text + "\nthe guest did not end within %d s" % options.seconds
        finally:
            try:
                bridge.wait(2)
            except subprocess.TimeoutExpired:
                pass
            stop(bridge)
    ended = re.search(r"^guest: exit (\d+)$", text, re.M)
    if not ended:
        return 1, text + "\nthe guest ended without an exit code"
    return int(ended.group(1)) or (1 if bridge.returncode else 0), text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bridge", default="build/hil/bridge", help="default: build/hil/bridge")
    parser.add_argument("--kernel", default="build/hil/kernel", help="folder of vmlinux and initrd (default: build/hil/kernel)")
    parser.add_argument("--seconds", type=int, default=60, help="deadline (default: 60)")
    device = parser.add_mutually_exclusive_group(required=True)
    device.add_argument("--here", action="store_true", help="the loop-back rig inside the bridge")
    device.add_argument("--app", action="store_true", help="the whole app inside the bridge")
    device.add_argument("--mailbox", metavar="FILE[:OFFSET]", help="a mailbox in shared memory")
    parser.add_argument("script")
    options = parser.parse_args()
    begin = time.monotonic()
    code, text = run_guest(options, options.script)
    print(text.strip())
    print("# boot to verdict %.1f s" % (time.monotonic() - begin))
    return code


if __name__ == "__main__":
    sys.exit(main())
