"""Runs sessions under fluoroscopy that a Python program controls."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import Any, NamedTuple, Union

from .scene import Scene, Tool
from .world import TICKS_PER_S, Place, Reading, World
from .xray import Picture, View, XRay

Speeds = Union[float, Sequence[float]]


class Frame(NamedTuple):
    """Holds what the operator of a session sees and feels."""

    tick: int
    reading: Reading
    tip: Place
    """Place of the tip of the tool at position 0."""
    picture: Picture
    """Picture whose exposure and lag depend on the session's earlier pictures."""


class Session:
    """A world under pulsed fluoroscopy, which a program controls pulse by pulse, and which is recorded on request.

    `Play` plays the session scripts of `cournand run`, whose hands slip and steer. `Recording` opens recordings.

        with cournand.Session("aorta", ["j_wire"], record="mine.rec") as session:
            for frame in session.lead(lambda frame: (0.03, 0.0), seconds=2):
                print(frame.tip.name, frame.reading.force_N[0])
    """

    def __init__(
        self,
        scene: Scene | str = "aorta",
        tools: Sequence[Tool | str] = ("j_wire",),
        *,
        pulses_per_s: float = 7.5,
        view: View | None = None,
        size: int = 512,
        labels: bool = False,
        seed: int = 0,
        record: str | os.PathLike[str] | None = None,
        **world: Any,
    ) -> None:
        """Makes a world with this scene and these tools, which are given as objects or by their names. Other arguments
        are passed to World.

        If no view is given, the C-arm is over the introducer. The seed determines the noise of the pictures.
        """
        if not 0.5 <= pulses_per_s <= 60.0:
            raise ValueError("pulses_per_s is not within 0.5 and 60")
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        opened = [tool if isinstance(tool, Tool) else Tool(tool) for tool in tools]
        self.world = World(self.scene, opened, **world)
        self.view = view if view is not None else View(isocentre_m=self.scene.entry_m)
        """The C-arm; assign another View to move it."""
        self._xray = XRay(self.scene, size)
        self._labels, self._seed = labels, seed
        self._ticks = TICKS_PER_S / pulses_per_s
        self._pulse = 0
        self._recording = ExitStack()
        if record is not None:
            self._recording.enter_context(self.world.record(record))

    def step(self, push: Speeds = 0.0, turn: Speeds = 0.0, *, inflator_kPa: float = 0.0) -> Frame:
        """Moves the hands at these speeds until the next pulse, and returns the frame of that pulse."""
        begin, end = round(self._pulse * self._ticks), round((self._pulse + 1) * self._ticks)
        self.world.move(push, turn, ticks=end - begin, inflator_kPa=inflator_kPa)
        self._pulse += 1
        return self.look()

    def look(self) -> Frame:
        """Returns the frame of the present moment, without a step."""
        seed = (self._seed * 1_000_003 + self._pulse) % 2**64
        picture = self._xray.render(self.world, self.view, labels=self._labels, sequence=True, seed=seed)
        return Frame(self.world.tick, self.world.read(), self.world.tip(), picture)

    def lead(self, policy: Callable[[Frame], tuple[Speeds, Speeds]], *, seconds: float) -> Iterator[Frame]:
        """Calls the policy at every pulse for the given time; the policy returns the push and the turn until the next
        pulse. Yields the frame after each step."""
        frame = self.look()
        for _ in range(round(seconds * TICKS_PER_S / self._ticks)):
            frame = self.step(*policy(frame))
            yield frame

    def close(self) -> None:
        """Completes the recording. The world can still be used afterwards."""
        self._recording.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
