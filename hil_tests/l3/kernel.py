#!/usr/bin/env python3
"""Provides Debian's own kernel for the guest machine of test level L3: downloads the packages and extracts the needed
files.

  kernel.py FOLDER     leaves vmlinux, initrd and usbtest.ko in FOLDER; does nothing when this program has made them

The kernel comes from the package on which linux-image-amd64 depends at the time of the download. The package is only
unpacked and never installed. The file vmlinux is the kernel inside vmlinuz, without the real-mode code and without
compression; the guest boots three seconds sooner with vmlinux than with vmlinuz. The initrd holds busybox, an init
program, and kernel modules: those for 9p, xHCI, EHCI, HID and a virtual serial port, and all modules on which these
depend. The init program runs one script in the host's file tree, which the guest sees read-only. One folder of the host
is writable in the guest at /mnt. The module usbtest is not loaded at the start; the program that needs it loads it."""

import hashlib
import io
import lzma
import os
import re
import subprocess
import sys
import tempfile

MODULES = ["virtio_pci", "virtio_console", "9pnet_virtio", "9p", "xhci_pci", "ehci_pci", "usbhid", "hid_generic"]
MODULES += ["usbmon"]
XZ_MAGIC = b"\xfd7zXZ\x00"

# The output of the serial line between the two marks is the command's; the last line is its exit code.
INIT = """#!/bin/sh
/bin/busybox mkdir -p /proc /sys /dev /host
/bin/busybox mount -t proc proc /proc
/bin/busybox mount -t sysfs sys /sys
/bin/busybox mount -t devtmpfs dev /dev
for module in $(/bin/busybox cat /modules/order); do
    /bin/busybox insmod /modules/$module || echo "guest: no $module"
done
/bin/busybox mount -t 9p -o trans=virtio,version=9p2000.L,ro,msize=262144 host /host || echo "guest: no file tree"
for place in proc sys dev; do /bin/busybox mount -o bind /$place /host/$place; done
/bin/busybox mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144 out /host/mnt || echo "guest: nowhere to write"
script=$(/bin/busybox sed -n 's/.*cournand_script=\\([^ ]*\\).*/\\1/p' /proc/cmdline)
echo "guest: up $(/bin/busybox cut -d' ' -f1 /proc/uptime)"
/bin/busybox chroot /host /bin/sh "$script"
echo "guest: exit $?"
/bin/busybox poweroff -f
"""


def run(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **options)
    if done.returncode != 0:
        text = done.stdout.decode("utf-8", "replace").strip()
        raise SystemExit("kernel.py: `%s` failed: %s" % (" ".join(command), text[-400:]))
    return done.stdout.decode("utf-8", "replace")


def fetch(folder):
    """Unpacks kernel and busybox below folder."""
    depends = run("apt-cache", "depends", "linux-image-amd64")
    found = re.search(r"Depends: (linux-image-\S+)", depends)
    if not found:
        raise SystemExit("kernel.py: apt does not know linux-image-amd64: run `apt-get update`")
    run("apt-get", "download", "-q", found.group(1), "busybox-static", cwd=folder)
    packages = [name for name in os.listdir(folder) if name.endswith(".deb")]
    for name in packages:
        run("dpkg-deb", "-x", os.path.join(folder, name), os.path.join(folder, "root"))


def extract_vmlinux(vmlinuz):
    """Returns the ELF file inside a bzImage."""
    place = vmlinuz.find(XZ_MAGIC)
    while place >= 0:
        try:
            image = lzma.LZMADecompressor(lzma.FORMAT_XZ).decompress(vmlinuz[place:])
            if image.startswith(b"\x7fELF"):
                return image
        except lzma.LZMAError:
            pass
        place = vmlinuz.find(XZ_MAGIC, place + 1)
    raise SystemExit("kernel.py: there is no xz-packed kernel in vmlinuz; see scripts/extract-vmlinux of the kernel")


def module_paths(root):
    """Returns a map from the names of kernel modules to their files; in the names, - counts as _."""
    paths = {}
    for folder, _, names in os.walk(root):
        for name in names:
            if name.endswith(".ko"):
                paths[name[:-3].replace("-", "_")] = os.path.join(folder, name)
    return paths


def dependencies(path):
    with open(path, "rb") as file:
        found = re.search(rb"\x00depends=([^\x00]*)\x00", file.read())
    return [name.replace("-", "_") for name in found.group(1).decode().split(",") if name] if found else []


def module_order(paths, wanted):
    """Returns the files of the modules, in the order in which the kernel must load them. A module without a file is
    built into the kernel, so its name is left out."""
    order, seen = [], set()

    def add(name):
        if name in seen:
            return
        seen.add(name)
        if name not in paths:
            return
        for other in dependencies(paths[name]):
            add(other)
        order.append(paths[name])

    for name in wanted:
        add(name)
    return order


def cpio_entry(out, number, name, mode, data=b""):
    """Appends one file to a `newc` archive: a header of hexadecimal numbers, the name and the contents, padded to
    multiples of 4 bytes."""
    path = name.encode() + b"\x00"
    fields = [number, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(path), 0]
    head = b"070701" + b"".join(b"%08x" % field for field in fields) + path
    out.write(head + b"\x00" * (-len(head) % 4))
    out.write(data + b"\x00" * (-len(data) % 4))


def make_initrd(root):
    out = io.BytesIO()
    paths = module_paths(os.path.join(root, "lib", "modules"))
    order = module_order(paths, MODULES)
    with open(os.path.join(root, "bin", "busybox"), "rb") as file:
        busybox = file.read()
    files = [
        ("init", 0o100755, INIT.encode()),
        ("bin/busybox", 0o100755, busybox),
        ("bin/sh", 0o120777, b"busybox"),
        ("modules/order", 0o100644, "\n".join(os.path.basename(path) for path in order).encode()),
    ]
    for path in order:
        with open(path, "rb") as file:
            files.append(("modules/" + os.path.basename(path), 0o100644, file.read()))
    number = 1
    for folder in ("bin", "modules", "dev"):
        cpio_entry(out, number, folder, 0o040755)
        number += 1
    for name, mode, data in files:
        cpio_entry(out, number, name, mode, data)
        number += 1
    cpio_entry(out, 0, "TRAILER!!!", 0)
    return out.getvalue()


def write(path, data):
    with open(path + ".part", "wb") as file:
        file.write(data)
    os.rename(path + ".part", path)


def prepare(folder):
    """Returns the paths of vmlinux and initrd; makes these files if they are missing."""
    names = ("vmlinux", "initrd", "usbtest.ko", "made_by")
    vmlinux, initrd, usbtest, stamp = (os.path.join(folder, name) for name in names)
    with open(os.path.abspath(__file__), "rb") as file:
        made_by = hashlib.sha256(file.read()).hexdigest()
    if all(os.path.exists(path) for path in (vmlinux, initrd, usbtest, stamp)):
        with open(stamp, encoding="ascii") as file:
            if file.read() == made_by:
                return vmlinux, initrd
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as unpacked:
        fetch(unpacked)
        root = os.path.join(unpacked, "root")
        kernels = [name for name in os.listdir(os.path.join(root, "boot")) if name.startswith("vmlinuz-")]
        with open(os.path.join(root, "boot", kernels[0]), "rb") as file:
            write(vmlinux, extract_vmlinux(file.read()))
        write(initrd, make_initrd(root))
        with open(module_paths(os.path.join(root, "lib", "modules"))["usbtest"], "rb") as file:
            write(usbtest, file.read())
        write(stamp, made_by.encode())
    return vmlinux, initrd


def main():
    if len(sys.argv) != 2:
        print("usage: kernel.py FOLDER", file=sys.stderr)
        return 2
    print("%s %s" % prepare(sys.argv[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
