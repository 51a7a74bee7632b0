"""Cournand simulates guidewires and catheters in living vessels, makes X-ray pictures with labels, and offers
environments for learning.

    import cournand
    scene = cournand.Scene("aorta")
    world = cournand.World(scene, [cournand.Tool("j_wire")])
    world.move(push=0.06, seconds=2)
    cournand.XRay(scene).render(world).save("wire.png")

Units are m, s, N, N m, rad, kPa and mg/ml. The patient frame has +x to the patient's left, +y to the head and +z to the
front. Tools are numbered from the innermost; node 0 is the leading tip. One tick is 1 ms. The guide to this package is
docs/python.md.
"""

from . import errors
from ._core import core_version as _core_version
from ._core import version as _version
from .batch import Batch, Pool
from .data import shipped_scenes, shipped_stents, shipped_tools
from .errors import (
    BadArgumentError,
    BadFileError,
    BadHandleError,
    BadSnapshotError,
    BadStateError,
    BusyError,
    DifferentError,
    Error,
    InternalError,
    NoMemoryError,
    RefusedError,
    ScriptError,
)
from .recording import INPUT, Recording, RecordingInfo
from .scene import Scene, Tool, Vessel
from .script import Moment, Play, play
from .session import Frame, Session
from .world import Contacts, Fault, Order, Patient, PatientReading, Place, Pose, Reading, World
from .xray import Label, Picture, View, XRay

__version__: str = _version()
CORE_VERSION: int = _core_version()
"""Equal versions of the core compute equal results from equal inputs, bit for bit, and replay each other's
recordings."""

__all__ = [
    "CORE_VERSION",
    "INPUT",
    "BadArgumentError",
    "BadFileError",
    "BadHandleError",
    "BadSnapshotError",
    "BadStateError",
    "Batch",
    "BusyError",
    "Contacts",
    "DifferentError",
    "Error",
    "Fault",
    "Frame",
    "InternalError",
    "Label",
    "Moment",
    "NoMemoryError",
    "Order",
    "Patient",
    "PatientReading",
    "Picture",
    "Place",
    "Play",
    "Pool",
    "Pose",
    "Reading",
    "Recording",
    "RecordingInfo",
    "RefusedError",
    "Scene",
    "ScriptError",
    "Session",
    "Tool",
    "Vessel",
    "View",
    "World",
    "XRay",
    "errors",
    "play",
    "shipped_scenes",
    "shipped_stents",
    "shipped_tools",
]
