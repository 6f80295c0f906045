"""Spheres path traced far away, as numpy arrays: frames and streams to read and write, and their reprojection to an eye.

>>> import equistream as es
>>> frame = es.read_frame("render/centre/frame.0000.exr")
>>> frame["depth"].shape
(480, 960)

`import equistream.mitsuba` adds a spherical camera and correct AOVs to Mitsuba 3. Conventions, all from one header of the
C++ library: the world is right-handed with +Y up, in metres; cameras look along -Z; pixel centres are at half-integers.
Errors are InputError (a ValueError: nothing was done) and WorkError (a RuntimeError); both say where, what was expected and
what was found in one line.
"""

from ._core import CODING_TEXTURES, InputError, MovingRegion, PatchAtlas, PosePath, VisibleLossMeter, WorkError
from ._core import version as __version__
from .cameras import EquirectCamera, FrameInfo, PerspectiveCamera, Pose, eye_pose, frame_info
from .colour import DisplayTransform, false_colour, quantise_8bit, to_display
from .depth import PatchRays, SceneDepth, patch_rays
from .frames import AOVS, Frame, Sequence, SequenceWriter, read_frame, read_frame_info, write_frame
from .reprojection import FILL_PASSES, METHODS, MIRRORS, ORIGINS, RELIABILITY_TOLERANCE, RISK_GROUPS, RISKS, EyePicture, Reprojector, reproject
from .streams import Feed, FeedFrame, FeedPicture, Picture, Stream, open_feed, open_stream

__all__ = [
    "AOVS", "CODING_TEXTURES", "DisplayTransform", "EquirectCamera", "EyePicture", "FILL_PASSES", "Feed", "FeedFrame", "FeedPicture", "Frame",
    "FrameInfo", "InputError", "METHODS", "MIRRORS", "MovingRegion", "ORIGINS", "PatchAtlas", "PatchRays", "PerspectiveCamera", "Picture", "Pose", "PosePath",
    "RELIABILITY_TOLERANCE", "RISKS", "RISK_GROUPS", "Reprojector", "SceneDepth", "Sequence", "SequenceWriter", "Stream",
    "VisibleLossMeter", "WorkError", "__version__",
    "eye_pose", "false_colour", "frame_info", "open_feed", "open_stream", "patch_rays", "quantise_8bit", "read_frame", "read_frame_info",
    "reproject", "to_display", "write_frame",
]
