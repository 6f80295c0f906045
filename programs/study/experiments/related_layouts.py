"""Spheres in other layouts (Ardouin et al. 2014) and on a cylinder (McMillan and Bishop 1995), with as many pixels each.

The wide sphere at the left eye is put into each layout, coded, and looked up once, bilinearly, as the left eye sees it: no parallax, so that layout and code
are all that is lost. A layout's pixel is the mean of four bilinear samples, or an equirect picture of half the source's width alone would be filtered. Where the
samples of a layout lie close differs, so that what it gains hangs on where the scene's path looks too.

The lookups are ours: FFmpeg's v360 takes the middles of an equirect picture's outermost samples for its edges, so that what it turns is off by up to half a
sample, the more the farther from straight ahead; check() says what that costs.
"""

import dataclasses
import math

import equistream as es
import numpy as np
from baselines import v360_flat
from drawing import rgb
from found import together_psnr
from presets import SEEDS
from steps import Failed

from .related_video import coded, counted, display, ffmpeg, file_of, indices, mean_bytes, sequence, write

OVERSAMPLED = 2
FACE_STEP = 16
"""Faces of a cube are whole macroblocks."""
CYLINDER_DEG = 60
LATITUDES_DEG = (45, 60)
LEAST_AGREEMENT_DB = 35
# Centre and right of each face; down is the third axis. Two rows, each of which goes on from face to face: around the horizon, and over the back.
FACES = (((-1, 0, 0), (0, 0, -1)), ((0, 0, -1), (1, 0, 0)), ((1, 0, 0), (0, 0, 1)),
         ((0, -1, 0), (0, 0, 1)), ((0, 0, 1), (0, 1, 0)), ((0, 1, 0), (0, 0, -1)))


@dataclasses.dataclass(frozen=True)
class Equirect:
    width: int
    name: str = "e"
    title: str = "equirect"
    closes = True

    @property
    def camera(self):
        return es.EquirectCamera(self.width, self.width // 2)

    @property
    def size(self):
        return self.camera.size

    def directions(self, points):
        return self.camera.directions(points)

    def points(self, directions):
        return self.camera.pixels(directions)


@dataclasses.dataclass(frozen=True)
class Cylinder:
    """Rows by the tangent of latitude, up to CYLINDER_DEG; beyond, its last rows."""
    width: int
    name: str = "cylinder"
    title: str = f"cylinder, {CYLINDER_DEG} degrees up and down"
    closes = True

    @property
    def radius_px(self):
        return self.width / (2 * math.pi)

    @property
    def size(self):
        return self.width, 2 * round(self.radius_px * math.tan(math.radians(CYLINDER_DEG)))

    def directions(self, points):
        longitude = (points[..., 0] / self.width - 0.5) * 2 * math.pi
        up = (self.size[1] / 2 - points[..., 1]) / self.radius_px
        return unit(np.stack([np.sin(longitude), up, -np.cos(longitude)], axis=-1))

    def points(self, directions):
        x, y, z = np.moveaxis(directions, -1, 0)
        longitude = np.arctan2(x, -z)
        return np.stack([(longitude / (2 * math.pi) + 0.5) * self.width, self.size[1] / 2 - self.radius_px * y / np.hypot(x, z)], axis=-1)


@dataclasses.dataclass(frozen=True)
class Cube:
    """Three faces by two. `equiangular`: a face's pixels are equal angles, else equal tangents."""
    face: int
    equiangular: bool
    name: str
    title: str
    closes = False

    @property
    def size(self):
        return 3 * self.face, 2 * self.face

    @staticmethod
    def axes():
        centre, right = np.array(FACES, float).transpose(1, 0, 2)
        return centre, right, np.cross(centre, right)

    def directions(self, points):
        column, row = (np.clip(points[..., i] // self.face, 0, most).astype(int) for i, most in ((0, 2), (1, 1)))
        a, b = (2 * (points[..., i] / self.face - cell) - 1 for i, cell in ((0, column), (1, row)))
        if self.equiangular:
            a, b = np.tan(a * math.pi / 4), np.tan(b * math.pi / 4)
        centre, right, down = (axis[3 * row + column] for axis in self.axes())
        return unit(centre + a[..., None] * right + b[..., None] * down)

    def points(self, directions):
        """Kept half a pixel inside their face, so that no lookup mixes faces that are no neighbours."""
        centre, right, down = self.axes()
        along = directions @ centre.T
        face = np.argmax(along, axis=-1)
        length = np.take_along_axis(along, face[..., None], axis=-1)[..., 0]
        a, b = ((directions * axis[face]).sum(axis=-1) / length for axis in (right, down))
        if self.equiangular:
            a, b = np.arctan(a) * 4 / math.pi, np.arctan(b) * 4 / math.pi
        inside = [np.clip((t + 1) / 2 * self.face, 0.5, self.face - 0.5) for t in (a, b)]
        return np.stack([inside[0] + face % 3 * self.face, inside[1] + face // 3 * self.face], axis=-1)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def layouts(width):
    """As many pixels each as a cube of whole macroblocks that has nearly as many as an equirect picture of this width; the first is what others stand beside."""
    face = max(1, round(width / math.sqrt(12) / FACE_STEP)) * FACE_STEP
    pixels = 6 * face ** 2
    cylinder = math.sqrt(pixels * math.pi / math.tan(math.radians(CYLINDER_DEG)))
    return (Equirect(4 * round(math.sqrt(2 * pixels) / 4)), Cube(face, False, "cube", "cube map"), Cube(face, True, "eac", "equi-angular cube map"),
            Cylinder(2 * round(cylinder / 2)))


def pixel_centres(size):
    return np.stack(np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5), axis=-1)


def look_up(picture, points, closes):
    """Bilinear; points are continuous pixel coordinates, centres at halves. Rows, and columns unless the picture closes on itself, end at its edge."""
    rows, columns = picture.shape[:2]
    x, y = points[..., 0] - 0.5, np.clip(points[..., 1] - 0.5, 0, rows - 1)
    x = x if closes else np.clip(x, 0, columns - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - left)[..., None].astype(np.float32), (y - top)[..., None].astype(np.float32)
    below, left, right = np.minimum(top + 1, rows - 1), left % columns, (left + 1) % columns
    return (picture[top, left] * (1 - s) + picture[top, right] * s) * (1 - t) + (picture[below, left] * (1 - s) + picture[below, right] * s) * t


def put_into(layout, picture):
    """An equirect picture, in another layout."""
    width, height = layout.size
    fine = pixel_centres((OVERSAMPLED * width, OVERSAMPLED * height)) / OVERSAMPLED
    samples = look_up(picture, Equirect(picture.shape[1]).points(layout.directions(fine)), True)
    return samples.reshape(height, OVERSAMPLED, width, OVERSAMPLED, -1).mean(axis=(1, 3))


def v360_turn(sphere, pose):
    """Yaw, pitch and roll in degrees: FFmpeg's axes are right, down and forward, and it rolls first, then pitches, then yaws."""
    flip = np.diag([1, -1, -1])
    turn = flip @ np.linalg.inv(sphere.matrix[:3, :3]) @ pose.matrix[:3, :3] @ flip
    return tuple(math.degrees(angle) for angle in (math.atan2(turn[0, 2], turn[2, 2]), math.asin(np.clip(-turn[1, 2], -1, 1)), math.atan2(turn[1, 0], turn[1, 1])))


def v360_words(sphere, camera, pose):
    yaw, pitch, roll = v360_turn(sphere, pose)
    return f"format=gbrp,{v360_flat(camera.size, math.degrees(camera.fov_x_rad))}:yaw={yaw:.6f}:pitch={pitch:.6f}:roll={roll:.6f}"


def check(work, frame, eye):
    """Our lookup of the wide sphere, and v360's, beside the client's own: dB."""
    picture = display(frame)
    theirs = es.Reprojector("rotation", fill="none")(frame, eye.camera, eye.camera_pose).rgb
    wide = Equirect(picture.shape[1])
    ours = look_up(picture, seen_points(wide, frame.info.camera_pose, eye.camera, eye.camera_pose), wide.closes)
    agreement = together_psnr([np.mean((ours - theirs) ** 2)])
    if agreement < LEAST_AGREEMENT_DB:
        raise Failed(f"layouts: expected lookups that agree with the client's to {LEAST_AGREEMENT_DB} dB, found {agreement:.1f} dB")
    write(work, "related/v360-of", 0, picture)
    command = ffmpeg(work, "-i", "related/v360-of/frame.0000.png", "-vf", v360_words(frame.info.camera_pose, eye.camera, eye.camera_pose), "related/v360.png")
    by_v360 = rgb(work.folder / "related/v360.png").astype(float)
    return {"ours_db": agreement, "v360_db": together_psnr([np.mean((by_v360 - theirs) ** 2)]), "n": {"frames": 1, "seeds": 1}, "command": command}


def eyes_of(work, seed):
    """Of each frame: the left eye, and the pose of the sphere that it looks at."""
    def info(folder, index):
        return es.read_frame_info(work.folder / folder / f"left/frame.{index:04}.exr")
    sphere = work.sphere("left", work.preset.sphere_width, seed)
    return {index: (info(work.truth(seed), index), info(sphere, index).camera_pose) for index in indices(work)}


def seen_points(layout, sphere_pose, camera, pose):
    """Where in a layout's picture an eye at the sphere's own place looks."""
    return layout.points(sphere_pose.to_camera(pose.to_world(camera.directions())))


def look_at(work, layout, eyes, views):
    """Looks up the left eye in pictures of a layout: {folder of pictures: folder of views}."""
    for index, (eye, sphere_pose) in eyes.items():
        points = seen_points(layout, sphere_pose, eye.camera, eye.camera_pose)
        for pictures, out in views.items():
            write(work, f"{out}/left", index, look_up(rgb(file_of(work, pictures, index)), points, layout.closes))


def make_layouts(work, chosen):
    """Each seed's sphere in every layout, and what check() says of the first frame."""
    for seed in SEEDS:
        for frame in sequence(work, f"{work.sphere('left', work.preset.sphere_width, seed)}/left", "colour"):
            picture = display(frame)
            for layout in chosen:
                write(work, f"related/{layout.name}-{seed}", frame.info.index, put_into(layout, picture))
            if (seed, frame.info.index) == (SEEDS[0], work.first):
                checked = check(work, frame, eyes_of(work, seed)[work.first][0])
    return checked


def beyond_share(eyes):
    """Of the eyes' pixels, how many lie beyond the cylinder."""
    up = [sphere_pose.to_camera(eye.camera_pose.to_world(eye.camera.directions()))[..., 1] for eye, sphere_pose in eyes.values()]
    return float(np.mean(np.abs(up) > math.sin(math.radians(CYLINDER_DEG))))


def layout_points(work, crfs):
    """Each layout before coding (crf None) and at each of `crfs`: bytes a frame, noise-free error of the left eye."""
    chosen = layouts(work.preset.half_width)
    checked, eyes = make_layouts(work, chosen), {seed: eyes_of(work, seed) for seed in SEEDS}
    points = []
    for layout in chosen:
        labels = {crf: f"related-{layout.name}-{'none' if crf is None else f'crf{crf:g}'}" for crf in (None, *crfs)}
        runs = {None: [(None, None)]}
        for seed in SEEDS:
            made, views = f"related/{layout.name}-{seed}", {}
            for crf, label in labels.items():
                pictures = made if crf is None else f"related/{label}-{seed}"
                views[pictures] = f"views/{label}-{seed}"
                if crf is not None:
                    runs.setdefault(crf, []).append(coded(work, made, crf, pictures))
            look_at(work, layout, eyes[seed], views)
        beyond = beyond_share(eyes[SEEDS[0]]) if isinstance(layout, Cylinder) else 0.0
        for crf, label in labels.items():
            points.append({"layout": layout.name, "title": layout.title, "size": list(layout.size), "crf": crf, "bytes_a_frame": mean_bytes(runs[crf]) if crf else None,
                           **work.scored(label, [f"views/{label}-{seed}" for seed in SEEDS], eyes="left"), "beyond_share": beyond, "n": counted(work),
                           "command": runs[crf][0][1]})
    return checked, points


def latitude_points(work, crfs):
    """Bytes of an equirect picture's rows up to some latitude; make_layouts() made it."""
    whole = layouts(work.preset.half_width)[0]
    height, points = whole.size[1], []
    for crf in crfs:
        for latitude_deg in (90, *LATITUDES_DEG):
            rows = 2 * round(height * latitude_deg / 90 / 2)
            runs = []
            for seed in SEEDS:
                source, out = f"related/{whole.name}-{seed}", f"related/rows{latitude_deg}-{seed}"
                for index in indices(work):
                    top = (height - rows) // 2
                    write(work, out, index, rgb(file_of(work, source, index))[top:top + rows])
                runs.append(coded(work, out, crf, f"related/rows{latitude_deg}-crf{crf:g}-{seed}"))
            points.append({"latitude_deg": latitude_deg, "crf": crf, "rows": rows, "pixel_share": rows / height, "solid_angle_share": math.sin(math.radians(latitude_deg)),
                           "bytes_a_frame": mean_bytes(runs), "n": counted(work), "command": runs[0][1]})
    return points
