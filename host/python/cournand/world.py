"""Makes worlds, which are simulated devices with their tools and, if requested, a patient."""

from __future__ import annotations

import enum
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .data import find
from .recording import INPUT, Recording
from .scene import Scene, Tool

POSITIONS_MAX = 3
TICKS_PER_S = 1000


class Pose(NamedTuple):
    """The shape of the tools. The arrays are read-only views of the world's memory; nothing is copied.

    The numbers of a view are valid until the next call that changes the world; copy the numbers that you need later
    (`pose.positions_m.copy()`). The memory of the world lives as long as its views.
    """

    tick: int
    positions_m: npt.NDArray[np.float32]
    """Positions of the nodes, float32 [n, 3], from the leading tip to the first node inside the introducer."""
    arcs_m: npt.NDArray[np.float32]
    """Arc length of each node from the leading tip along the unstretched rod, float32 [n]."""
    radii_m: npt.NDArray[np.float32]
    """Outer radius of the outermost tool at each node, float32 [n]."""
    tip_arcs_m: npt.NDArray[np.float32]
    """Arc length of each tool's tip from the leading tip, float32 [positions]."""
    inserted_m: npt.NDArray[np.float32]
    """Length of each tool beyond the introducer's opening, float32 [positions]."""
    positions_q30: npt.NDArray[np.int32]
    """Exact positions of the nodes, int32 [n, 3] in units of 2^-30 m."""


class Contacts(NamedTuple):
    """Forces of the vessel wall on the nodes, as views like those of Pose."""

    tick: int
    nodes: npt.NDArray[np.uint32]
    """uint32 [count], ascending."""
    forces_N: npt.NDArray[np.float32]
    """Force of the wall on each node (normal force plus friction), float32 [count, 3]."""


class Reading(NamedTuple):
    """Values that were measured after the last tick; before the first tick, all values except lengths and phases are
    0."""

    tick: int
    contact_count: int
    fault_bits: int
    """Fault bits, which stay set: 1 saturated, 2 hand too fast, 4 step capped, 8 end of the tool, 16 outside."""
    line: tuple[int, ...]
    """Number of the tool at each position, from 1; 0 if the position has no tool."""
    inserted_m: tuple[float, ...]
    force_N: tuple[float, ...]
    """Forces on the hands; positive values push the tools out."""
    torque_N_m: tuple[float, ...]
    """Torques on the hands; positive values oppose a positive rotation."""
    penetration_m: float
    length_error: float
    wall_force_N: float
    """Sum of all contact forces in the last sample; 0 if `contact_ticks` is 0."""
    wall_force_peak_N: float
    """The largest sample during the last call of move() or advance()."""
    heart_phase: float
    breath_phase: float
    balloon_kPa: float
    balloon_diameter_max_m: float
    balloon_diameter_min_m: float
    balloon_wall_N: float
    balloon_has_burst: bool
    exchange: int
    """Result of an exchange of tools in the last tick: 0 if there was none, 1 if it was done, otherwise a code of
    docs/faults.md."""
    out_of_range_tick: int | None
    """Tick since which the results are not valid, because the simulation left its valid range; None if all results are
    valid."""


class Place(NamedTuple):
    """Describes where the tip of a tool is."""

    name: str
    """Name of the vessel; "" if it is not known."""
    vessel: int
    """Number of the vessel in `scene.vessels`; -1 if it is not known."""
    tip_m: tuple[float, float, float]
    along_m: float
    """From the vessel's beginning."""
    inside_m: float
    """Distance from the vessel's ostium to the tip, along the path from the introducer."""
    radii: float
    """Distance of the tip from the centreline, in radii of the lumen; above 1, the tip is outside."""


class Fault(NamedTuple):
    """A fault that the device has counted (docs/faults.md)."""

    code: int
    tick_first: int
    tick_last: int
    times: int
    value1: int
    value2: int
    text: str
    remedy: str


class PatientReading(NamedTuple):
    """Values of a patient: syringe, pressures, heart rate and stents."""

    stents_loaded: int
    injected_ml: float
    injection_flow_ml_per_s: float
    pressure_mmHg: float
    """Pressure at the catheter's tip if a catheter lies in the vessels, otherwise in the aorta."""
    heart_rate_per_min: float
    stent_stage: str
    notice: str
    """Text of the last refusal by the syringe or of a stent; "" if there was none."""


class Order(enum.IntEnum):
    """Kinds of orders to the core; docs/wire.md lists their values."""

    RHYTHM = 1
    SCAFFOLD = 2
    STRUT = 3
    EXCHANGE = 4


class Patient:
    """The patient of a world that was made with `patient=True`: blood flow, contrast medium, stents and pressures."""

    def __init__(self, world: World) -> None:
        self._world = world

    def inject(self, ml: float, *, ml_per_s: float, position: int = -1, iodine_mg_per_ml: float = 300.0) -> None:
        """Injects contrast medium from the next tick on: 0 .. 200 ml at 0.001 .. 50 ml/s. A volume of 0 ml ends an
        injection.

        `position` is the position of the injecting tool; -1 selects the outermost tool that has a lumen. If a problem
        appears only in that tick, such as a pressure above the syringe's limit, `read().notice` states it.
        """
        self._world._core.inject(ml, ml_per_s, position, iodine_mg_per_ml)

    def load_stent(self) -> None:
        """Mounts the next stent of the world on the balloon in use."""
        self._world._core.load_stent()

    def read(self) -> PatientReading:
        """Returns the present values of syringe, pressures, heart rate and stents."""
        return PatientReading._make(self._world._core.read_patient())


class World:
    """A simulated device with one to eight tools, at most three of them in use at a time, and with a patient if
    requested.

    The same scene, tools, options and orders give the same results on every machine, bit for bit, with any number of
    threads. Only one thread at a time may use a world; a call from a second thread raises BusyError. Long calls release
    the interpreter's lock.
    """

    def __init__(
        self,
        scene: Scene,
        tools: Sequence[Tool],
        *,
        line: Sequence[int] = (),
        inserted_m: Sequence[float] = (),
        patient: bool = False,
        contact_ticks: int = 0,
        stents: Sequence[str | os.PathLike[str]] = (),
    ) -> None:
        """Makes a world at tick 0. `tools` are in order from the innermost outwards.

        `line` lists the number of the tool in `tools`, from 1, at each position; 0 stands for a position without a
        tool. If `line` is not given, all tools are in use; there may be at most three. `inserted_m` lists, for the tool
        at each position, its length beyond the introducer's opening at tick 0; NaN stands for the scene's start length.
        `contact_ticks` is the number of ticks between two samples of the wall forces, 1 .. 1000; 0 switches the samples
        off. `stents` lists the stents that may be mounted, in this order; they need a patient.
        """
        self.scene = scene
        self.tools = tuple(tools)
        paths = [find("stents", ".toml", stent) for stent in stents]
        cores = [tool._core for tool in self.tools]
        options = (list(line), list(inserted_m), patient, contact_ticks, paths)
        self._make(lambda: _core.World(scene._core, cores, *options), patient)

    def _make(self, make_core: Callable[[], Any], has_patient: bool) -> None:
        self._make_core, self._has_patient = make_core, has_patient
        self._core = make_core()
        self.position_count: int = len(self._core.read()[3])
        """Number of positions for tools in use, 1 .. 3."""

    # --- advancing ---

    def move(
        self,
        push: float | Sequence[float] = 0.0,
        turn: float | Sequence[float] = 0.0,
        *,
        ticks: int | None = None,
        seconds: float | None = None,
        inflator_kPa: float = 0.0,
    ) -> None:
        """Moves the hands at constant speeds for a number of ticks or for a time.

        `push` is in m/s, -1 .. 1, positive into the patient, and `turn` in rad/s, -100 .. 100, right-handed about the
        direction of insertion. A single number applies to position 0; a sequence has a number for each position. Hands
        hold their tools rigidly.
        """
        if (ticks is None) == (seconds is None):
            raise TypeError("move() needs either `ticks` or `seconds`")
        count = ticks if ticks is not None else round(float(seconds or 0.0) * TICKS_PER_S)
        action = _per_position(push, "push") + _per_position(turn, "turn") + [float(inflator_kPa), 0.0]
        self._core.move(action, count)

    def advance(self, inputs: npt.NDArray[Any]) -> None:
        """Advances the world by one tick per input. `inputs` is an array [ticks] of the type `cournand.INPUT`, which
        holds the exact counts of the hands and the orders of every tick, as a recording does. An array of another type
        raises TypeError."""
        if not isinstance(inputs, np.ndarray) or inputs.dtype != INPUT or inputs.ndim != 1:
            raise TypeError("inputs is not an array with one axis and the type cournand.INPUT")
        given = np.ascontiguousarray(inputs)
        self._core.advance(given.view(np.uint8).reshape(given.size, INPUT.itemsize))

    def order(self, kind: Order, *values: int) -> None:
        """Requests an order for the core's next tick. The core first tries the order on a copy of its state."""
        self._core.order(int(kind), list(values))

    def exchange(self, position: int, tool: int) -> None:
        """Takes tools out of use, and puts the tool with this number (from 1; 0 for none) into use
        (docs/session.md)."""
        self.order(Order.EXCHANGE, position, tool)

    # --- reading ---

    @property
    def tick(self) -> int:
        return int(self._core.read()[0])

    def pose(self) -> Pose:
        """Returns the shape of the tools now, as views."""
        return Pose._make(self._core.pose())

    def contacts(self) -> Contacts:
        """Returns the forces of the wall on the nodes now, as views."""
        return Contacts._make(self._core.contacts())

    def read(self) -> Reading:
        """Returns forces, lengths, phases and faults after the last tick."""
        return Reading._make(self._core.read())

    def tip(self, position: int = 0) -> Place:
        """Returns the vessel in which the tip of a tool lies, and how far the tip is inside this vessel."""
        return Place._make(self._core.tip(position))

    def moved(self, rest_m: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Returns where points of the tissue are now, float64 [n, 3]. `rest_m` are n points in the reference pose
        (heart and breath at rest), such as points of a vessel's centreline. In a scene that does not move, the points
        stay."""
        points = np.array(rest_m, dtype=np.float64, order="C")
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError("rest_m is not an array [n, 3]")
        self._core.move_points(points)
        return points

    def hash(self) -> int:
        """Returns the full hash of the core's state, as `cournand run` prints it."""
        return int(self._core.hash())

    def faults(self) -> list[Fault]:
        """Returns the faults that the device has counted, in the order of their codes."""
        return [Fault._make(fault) for fault in self._core.faults()]

    @property
    def patient(self) -> Patient | None:
        """The patient of a world that was made with `patient=True`; otherwise None."""
        return Patient(self) if self._has_patient else None

    # --- snapshots ---

    def snapshot(self) -> bytes:
        """Returns the state as bytes with a version and a checksum: 37 kB, and about 30 kB more with a patient."""
        return bytes(self._core.save())

    def restore(self, snapshot: bytes) -> None:
        """Sets the world to the state in a snapshot of any world with the same scene, tools and options, also from
        another process or machine. After the call, the world continues bit for bit as the saved one."""
        self._core.restore(snapshot)

    def fork(self) -> World:
        """Returns another world with the same set-up and state, for example for each branch of a search."""
        snapshot = self.snapshot()
        made = World.__new__(World)
        made.scene, made.tools = self.scene, self.tools
        made._make(self._make_core, self._has_patient)
        made.restore(snapshot)
        return made

    # --- recordings ---

    @contextmanager
    def record(self, path: str | os.PathLike[str], session: str = "python") -> Iterator[None]:
        """Records the world from tick 0 to the end of the `with` block, as a file for `cournand replay`.

        The file gets its name when the recording is complete.
        """
        self._core.record(os.fspath(path), session)
        try:
            yield
        finally:
            self._core.end_recording()

    def replay(self, recording: Recording, tick: int | None = None) -> None:
        """Replays a recording up to a tick, or to its end, and compares every tick with the recording."""
        self._core.replay(recording._core, recording.info.tick_count if tick is None else tick)

    def __repr__(self) -> str:
        return "<cournand.World %s in %s>" % (" + ".join(tool.name for tool in self.tools), self.scene.name)


def _per_position(given: float | Sequence[float], name: str) -> list[float]:
    speeds = [float(given)] if isinstance(given, (int, float, np.number)) else [float(one) for one in given]
    if len(speeds) > POSITIONS_MAX:
        raise ValueError("%s has %d numbers: a line has at most %d positions" % (name, len(speeds), POSITIONS_MAX))
    return speeds + [0.0] * (POSITIONS_MAX - len(speeds))


def world_of_recording(recording: Recording, scene: Scene, patient: bool) -> World:
    """Makes the world of Recording.world()."""
    made = World.__new__(World)
    made.scene, made.tools = scene, ()
    made._make(lambda: recording._core.world(scene._core, patient), patient)
    return made
