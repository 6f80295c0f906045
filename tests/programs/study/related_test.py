"""Cells of surfaces whose mesh is known, layouts beside the client's own lookup and FFmpeg's, differences there and back."""

import math
import tempfile
import types
import unittest
from pathlib import Path

import equistream as es
import numpy as np
from drawing import rgb
from found import together_psnr
from PIL import Image

from experiments import parsimony, related, related_layouts, related_streams

WIDTH, BOX_M, BUDGET_RAD = 256, 0.1, 1e-3
CELLS = WIDTH * (WIDTH // 2 + 1)
LAYOUTS = related_layouts.layouts(WIDTH)


def floor_m(height_m=1.6):
    """Below the horizon a plane, above it nothing: both are planes in 1/r."""
    down = es.EquirectCamera(WIDTH, WIDTH // 2).directions()[..., 1]
    with np.errstate(divide="ignore"):
        return np.where(down < 0, -height_m / down, np.inf)


class Cells(unittest.TestCase):
    def test_a_floor_is_whole_blocks_but_along_the_horizon(self):
        found = parsimony.count_cells(floor_m(), BOX_M, BUDGET_RAD)
        self.assertEqual(found[32], 3 * WIDTH // 32)
        self.assertLess(sum(found.values()), CELLS / 25)

    def test_steps_everywhere_leave_single_cells(self):
        depth_m = np.where(np.arange(WIDTH) % 2 == 0, 1.0, 3.0) * np.ones((WIDTH // 2, 1))
        self.assertEqual(parsimony.count_cells(depth_m, BOX_M, BUDGET_RAD), {1: CELLS, 2: 0, 4: 0, 8: 0, 16: 0, 32: 0})

    def test_cells_cover_everything_once(self):
        depth_m = floor_m() + np.random.default_rng(1).choice([0, 0.001, 1], (WIDTH // 2, WIDTH), p=[0.98, 0.015, 0.005])
        found = parsimony.count_cells(depth_m, BOX_M, BUDGET_RAD)
        self.assertEqual(sum(count * side ** 2 for side, count in found.items()), CELLS)
        self.assertGreater(found[1], found[2])

    def test_a_larger_budget_takes_fewer(self):
        bulging = np.full((WIDTH // 2, WIDTH), 2.0)
        counts = [sum(parsimony.count_cells(bulging, BOX_M, budget).values()) for budget in (1e-4, 1e-3, 1e-2)]
        self.assertGreater(counts[0], counts[1])
        self.assertGreater(counts[1], counts[2])

    def test_a_fold_from_the_first_corner_to_the_opposite_one_is_held(self):
        side, fine = 32, es.EquirectCamera(1024, 512)
        folded = {}
        for ends in (((0, 0), (side, side)), ((side, 0), (0, side))):
            first, last = (fine.directions(np.array([x + 0.5, 255.5 + y])) for x, y in ends)
            with np.errstate(divide="ignore"):
                depth_m = 1 / np.maximum(0, 0.3 * fine.directions() @ np.cross(first, last) / np.linalg.norm(np.cross(first, last)))
            folded[ends[0]] = parsimony.holds(parsimony.Lattice(depth_m), np.array([256]), np.array([0]), side, BOX_M, BUDGET_RAD / 8)[0]
        self.assertEqual(folded, {(0, 0): True, (side, 0): False})

    def test_over_a_pole_lies_the_row_half_a_turn_on(self):
        lattice = parsimony.Lattice(np.random.default_rng(2).random((WIDTH // 2, WIDTH)) + 1)
        for over, inside in ((0, 1), (-1, -2)):
            np.testing.assert_array_equal(lattice.k[over, :WIDTH // 2], lattice.k[inside, WIDTH // 2:WIDTH])
            cosines = (lattice.q[over] * lattice.q[inside]).sum(axis=-1)
            np.testing.assert_allclose(cosines, math.cos(2 * math.pi / WIDTH), atol=1e-6)

    def test_a_grid_puts_a_floor_back(self):
        depth_m, cells = related.coarsened(np.full((WIDTH // 2, WIDTH), 2.0, np.float32), 8)
        np.testing.assert_allclose(depth_m, 2, rtol=1e-6)
        self.assertEqual(cells, WIDTH // 8 * (WIDTH // 2 // 8))

    def test_a_grid_is_linear_between_its_points(self):
        found, points = related.weights(16, 5, closes=False)
        np.testing.assert_allclose(found @ points, np.arange(16), atol=1e-12)
        np.testing.assert_allclose(related.weights(16, 4, closes=True)[0].sum(axis=1), 1)


def smooth_frame():
    """Bent waves, which a lookup in the wrong place shows."""
    camera = es.EquirectCamera(WIDTH, WIDTH // 2)
    info = es.FrameInfo()
    info.camera, info.camera_pose = camera, es.Pose((0, 0, 0), (math.cos(0.2), 0, math.sin(0.2), 0))
    x, y, z = np.moveaxis(camera.directions(), -1, 0)
    colour = np.stack([0.3 + 0.25 * np.sin(3 * x + y), 0.3 + 0.25 * np.sin(2 * y - z), 0.3 + 0.25 * np.sin(2 * z + 1), np.ones_like(x)], axis=-1)
    return es.Frame(info, {"colour": colour.astype(np.float32)})


EYE = es.PerspectiveCamera(160, 90, math.radians(90))
TURNED = es.Pose.look_at((0, 0, 0), (1, -0.4, 0.7), (0.2, 1, 0))


class Layouts(unittest.TestCase):
    def test_they_have_equally_many_pixels(self):
        pixels = [layout.size[0] * layout.size[1] for layout in related_layouts.layouts(1920)]
        self.assertLess(max(pixels) / min(pixels), 1.01)

    def test_points_lead_to_directions_and_back(self):
        for layout in LAYOUTS:
            points = related_layouts.pixel_centres(layout.size)
            np.testing.assert_allclose(layout.points(layout.directions(points)), points, atol=1e-6, err_msg=layout.name)

    def test_faces_of_a_row_go_on_from_each_other(self):
        for layout in LAYOUTS[1:3]:
            d = layout.directions(related_layouts.pixel_centres(layout.size))
            across = np.arccos((d[:, layout.face - 1::layout.face][:, :2] * d[:, layout.face::layout.face]).sum(axis=-1))
            self.assertLess(across.max(), 2.5 / layout.face, layout.name)

    def test_each_looks_up_what_the_client_does(self):
        frame = smooth_frame()
        theirs = es.Reprojector("rotation", fill="none")(frame, EYE, TURNED).rgb
        up = np.abs(frame.info.camera_pose.to_camera(TURNED.to_world(EYE.directions()))[..., 1])
        on_cylinder = up < math.sin(math.radians(related_layouts.CYLINDER_DEG - 1))
        for layout in LAYOUTS:
            picture = related_layouts.put_into(layout, related_layouts.display(frame))
            points = related_layouts.seen_points(layout, frame.info.camera_pose, EYE, TURNED)
            ours = related_layouts.look_up(picture, points, layout.closes)
            inside = on_cylinder if layout.name == "cylinder" else np.ones_like(on_cylinder)
            self.assertGreater(together_psnr([np.mean((ours - theirs)[inside] ** 2)]), 50, layout.name)

    def test_v360_is_turned_as_the_client_is(self):
        frame = smooth_frame()
        theirs = es.Reprojector("rotation", fill="none")(frame, EYE, TURNED).rgb
        with tempfile.TemporaryDirectory() as folder:
            Image.fromarray(related_layouts.display(frame)).save(f"{folder}/sphere.png")
            words = related_layouts.v360_words(frame.info.camera_pose, EYE, TURNED)
            related_layouts.ffmpeg(types.SimpleNamespace(folder=folder), "-i", "sphere.png", "-vf", words, "eye.png")
            turned = rgb(Path(folder) / "eye.png").astype(float)
        self.assertGreater(together_psnr([np.mean((turned - theirs) ** 2)]), 35)


class Differences(unittest.TestCase):
    def test_they_come_back(self):
        true, shown = np.meshgrid(np.arange(256, dtype=np.uint8), np.arange(256, dtype=np.uint8))
        back = related_streams.with_difference(shown, related_streams.difference_code(true, shown))
        self.assertLessEqual(np.abs(back - true).max(), 1)
        self.assertLess(abs((back - true).mean()), 0.02)


if __name__ == "__main__":
    unittest.main()
