"""Plays session scripts: the sessions that `cournand run` plays, tick by tick in a Python program."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from . import _core
from .data import find
from .errors import BadArgumentError
from .scene import Scene, Tool
from .world import TICKS_PER_S, Place, Reading, World
from .xray import Picture, View, XRay

_TICKS_MAX = 600_000
_CALL_TICKS = 1000  # of one call of the library, so that Ctrl-C ends a long play


class Moment(NamedTuple):
    """The state of a play at one tick."""

    tick: int
    reading: Reading
    tip: Place
    """Place of the tip of the tool at position 0."""


class Play:
    """A session that a script leads (docs/session.md), with a patient, hands that slip and steer, and the X-ray room.

    It computes what `cournand run` computes, bit for bit. An expectation that does not hold is no exception: it ends
    the script, and `failures` and the report state it.

        play = cournand.Play("mine.session", record="mine.rec")
        for moment in play.pulses():
            print(moment.tip.name, play.picture().tube_voltage_kV)
        print(play.report()["failures"])
    """

    def __init__(
        self,
        script: str | os.PathLike[str],
        scene: Scene | str | None = None,
        tools: Sequence[Tool | str] = (),
        *,
        stents: Sequence[str | os.PathLike[str]] = (),
        hands: str = "",
        record: str | os.PathLike[str] | None = None,
        size: int = 512,
    ) -> None:
        """Reads the script and begins its session at tick 0.

        `scene`, `tools` and `stents` replace what the `needs` statements of the script name; a script that names no
        scene plays in free space. The script names a tool by its file's name. `hands` is a skill with a seed, such as
        "novice:7". `size` is the size of the pictures in pixels. A mistake in the script raises ScriptError.
        """
        self._script = _core.Script(os.fspath(script), hands)
        _, needed_scene, needed_tools, needed_stents, _ = self._script.describe()
        chosen = scene if scene is not None else needed_scene
        self.scene: Scene = chosen if isinstance(chosen, Scene) else Scene(chosen or None)
        named: Sequence[Tool | str] = tools or needed_tools
        self.tools: tuple[Tool, ...] = tuple(one if isinstance(one, Tool) else Tool(one) for one in named)
        paths = [find("stents", ".toml", stent) for stent in stents or needed_stents]
        if not self.tools:
            raise ValueError("%s names no tool. Remedy: add `needs tools NAME`, or give `tools`" % os.fspath(script))
        cores = [tool._core for tool in self.tools]
        file = "" if record is None else os.fspath(record)
        self._core = _core.Play(self._script, self.scene._core, cores, paths, file)
        self._size = size
        self._xray: XRay | None = None
        self.world: World = self._led_world()
        """The world of the session, which can be read, rendered and forked; only the script moves it."""

    def _led_world(self) -> World:
        world = World.__new__(World)
        world.scene, world.tools = self.scene, self.tools
        world._make(self._core.world, True)
        world._make_core = self._core.new_world  # a fork is free to move
        return world

    # --- advancing ---

    def advance(self, *, ticks: int | None = None, seconds: float | None = None) -> None:
        """Advances the session by this time, or to the end of the script if that comes first. The moments at which the
        calls stop change nothing in the session."""
        if (ticks is None) == (seconds is None):
            raise TypeError("advance() needs either `ticks` or `seconds`")
        self._core.advance(_checked(ticks if ticks is not None else round(float(seconds or 0.0) * TICKS_PER_S)), False)

    def moments(self, every_s: float) -> Iterator[Moment]:
        """Plays to the end of the script, and yields the state after each interval and at the end."""
        ticks = _checked(round(every_s * TICKS_PER_S))
        while not self.is_over:
            self._core.advance(ticks, False)
            yield self.now()

    def pulses(self) -> Iterator[Moment]:
        """Plays to the end of the script, and yields the state at each later pulse of the X-ray room."""
        while not self.is_over:
            self._core.advance(_CALL_TICKS, True)
            if self._core.read()[2]:
                yield self.now()

    def finish(self) -> dict[str, Any]:
        """Plays to the end of the script, and returns the report."""
        while not self.is_over:
            self._core.advance(_CALL_TICKS, False)
        return self.report()

    # --- reading ---

    @property
    def tick(self) -> int:
        return int(self._core.read()[0])

    @property
    def is_over(self) -> bool:
        """True when the script has ended; the report and the recording are then complete."""
        return bool(self._core.read()[1])

    @property
    def is_beam_on(self) -> bool:
        return bool(self._core.read()[3])

    @property
    def pulse_count(self) -> int:
        """Number of the pulses of the X-ray room up to now."""
        return int(self._core.read()[4])

    @property
    def exit_status(self) -> int:
        """What `cournand run` returns at the end: 0 success, 1 failed or refused, 3 outside the valid range."""
        return int(self._core.read()[5])

    @property
    def failures(self) -> list[str]:
        """The goals that were not reached and the expectations that did not hold, each as "FILE:LINE: text"."""
        text: str = self._core.read()[6].decode("utf-8", "replace")
        return text.splitlines()

    def now(self) -> Moment:
        """Returns the state of the session now."""
        return Moment(self.world.tick, self.world.read(), self.world.tip())

    def view(self) -> View:
        """Returns the C-arm of the X-ray room now."""
        return View(*self._core.view())

    def picture(self, view: View | None = None, **options: Any) -> Picture:
        """Renders the session now. If no view is given, the C-arm of the X-ray room is used. `options` are those of
        XRay.render()."""
        if self._xray is None:
            self._xray = XRay(self.scene, self._size)
        return self._xray.render(self.world, self.view() if view is None else view, **options)

    def report(self) -> dict[str, Any]:
        """Returns the report of the session, as `cournand run --json` writes it (docs/output.md)."""
        made: dict[str, Any] = json.loads(self.report_json())
        return made

    def report_json(self) -> str:
        """Returns the text of the report, with the same bytes as the file of `cournand run --json`."""
        return bytes(self._core.report()).decode("utf-8", "surrogateescape")

    def __repr__(self) -> str:
        return "<cournand.Play of %s, tick %d%s>" % (self._script.describe()[0], self.tick, ", over" * self.is_over)


def _checked(ticks: int) -> int:
    """Returns a number of ticks that one call of the library accepts."""
    if not 1 <= ticks <= _TICKS_MAX:
        raise BadArgumentError("%r ticks are not within 1 and %d (0.001 to 600 seconds)" % (ticks, _TICKS_MAX))
    return ticks


def play(script: str | os.PathLike[str], scene: Scene | str | None = None, **options: Any) -> dict[str, Any]:
    """Plays a script to its end, and returns its report. The arguments are those of Play."""
    return Play(script, scene, **options).finish()
