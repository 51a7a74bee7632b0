"""Starts the program's window on a virtual display, gives it the keyboard focus, and waits until the window shows a
given control.
The scripts that measure the window use this file."""

import contextlib
import ctypes
import os
import subprocess
import sys
import tempfile
import time


def display():
    """Starts a virtual display that chooses its own number; returns the server's process and the display's number."""
    reader, writer = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1600x900x24", "-nolisten", "tcp", "-noreset"],
        pass_fds=[writer],
        stderr=subprocess.DEVNULL,
    )
    os.close(writer)
    with os.fdopen(reader) as number:
        return server, ":" + number.readline().strip()


@contextlib.contextmanager
def window_of(options, words, has_layout=False, **more):
    """Runs the window on a virtual display; yields the window's process, its environment and its folder. With
    `has_layout`, the window lists the controls on its screen in the file `layout` of its folder. A script
    that measures the speed of the window leaves this file out."""
    with tempfile.TemporaryDirectory() as folder:
        server, number = display()
        environment = dict(os.environ, DISPLAY=number, XDG_STATE_HOME=folder, XDG_DATA_HOME=folder)
        command = [os.path.join(options.build, "bin", "cournand"), "view", "--no-help-panel", *words]
        command += ["--timing", os.path.join(folder, "timing.json")]
        command += ["--layout", os.path.join(folder, "layout")] if has_layout else []
        window = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, **more)
        try:
            yield window, environment, folder
        finally:
            window.kill()
            server.kill()
            server.wait()


def script():
    """Returns the name of the script that was called, for messages."""
    return os.path.basename(sys.argv[0])


class Keyboard:
    """Presses and releases keys on a display through the X11 extension XTEST, and records the time of each event."""

    def __init__(self, display_name):
        self.x11 = ctypes.CDLL("libX11.so.6")
        self.xtst = ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.x11.XStringToKeysym.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(display_name.encode()))
        if not self.display:
            sys.exit("%s: no display '%s'" % (script(), display_name))

    def send(self, key, is_down):
        """Sends one press or release of a key; returns the time of the monotonic clock, in seconds, at which it was
        sent."""
        symbol = ctypes.c_ulong(self.x11.XStringToKeysym(key.encode()))
        code = self.x11.XKeysymToKeycode(self.display, symbol) & 0xFF
        sent = time.monotonic()
        self.xtst.XTestFakeKeyEvent(self.display, code, int(is_down), 0)
        self.x11.XSync(self.display, 0)
        return sent

    def close(self):
        self.x11.XCloseDisplay(self.display)


def focus(environment, seconds=30.0):
    """Gives the window the keyboard."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = subprocess.run(
            ["xdotool", "search", "--onlyvisible", "--name", "^Cournand$"],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        ).stdout.split()
        if found:
            subprocess.run(["xdotool", "windowfocus", found[-1]], env=environment, check=False)
            return
        time.sleep(0.2)


def shows(layout, control, window):
    """Waits until the window shows the given control. Error messages name the script that was called."""
    for _ in range(6000):
        if os.path.exists(layout):
            with open(layout, encoding="utf-8") as file:
                if any(line.split("\t")[0] == control for line in file):
                    return
        if window.poll() is not None:
            sys.exit("%s: the window ended before it showed '%s'" % (script(), control))
        time.sleep(0.05)
    sys.exit("%s: the window does not show '%s'" % (script(), control))
