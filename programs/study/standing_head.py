"""A head that stands still, as the camera path that programs take (docs/scenes.md)."""

LAST_S = 60.0
"""Beyond every scene's own path."""


def path_text(position_m, orientation_wxyz):
    pose = ",".join(repr(float(value)) for value in (*position_m, *orientation_wxyz))
    return "\n".join(["time_s,x,y,z,qw,qx,qy,qz", *(f"{time_s},{pose}" for time_s in (0.0, LAST_S))]) + "\n"
