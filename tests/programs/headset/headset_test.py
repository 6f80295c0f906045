"""`equistream view --headset` in a runtime that records what it is given: pictures, held to the window and to `play`.

usage: headset_test.py BIN_DIR RUNTIME_LIBRARY
"""

from worn import *  # noqa: F403


class Pictures(Worn):
    def covering(self, view):
        """Size and field of view of the symmetric picture that a view is part of, and where in it."""
        width, height = view["swapchain"][0] // 2, view["swapchain"][1]
        left, right, up, down = np.tan(view["fov"])
        focal = view["rect"][2] / (right - left)
        column, bottom, columns, rows = view["rect"]
        column %= width
        self.assertAlmostEqual(focal, rows / (up - down), delta=1e-3 * focal)  # square pixels
        self.assertAlmostEqual(column - width / 2, focal * left, delta=0.01)
        self.assertAlmostEqual(bottom - height / 2, focal * down, delta=0.01)
        place = np.s_[height - bottom - rows : height - bottom, column : column + columns]
        return (width, height), 2 * np.degrees(np.arctan(width / 2 / focal)), place

    def test_a_head_at_rest_sees_what_the_window_shows(self):
        frames, _, _ = self.worn([STILL, STILL, "exit"])
        frame = frames[1]
        (width, height), fov, _ = self.covering(frame["views"][0])
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", pathlib.Path(tempfile.mkdtemp(dir=self.root)), self.stream, "--paused", "--scene",
                               self.scene, "--layout", "sbs", "--size", f"{2 * width}x{height}", "--fov", f"{fov:.9g}", "--ipd", IPD_M)
        self.addCleanup(viewer.close)
        both = viewer.picture()
        self.assertEqual(both.shape, (height, 2 * width, 3))
        for eye, view in enumerate(frame["views"]):
            _, _, place = self.covering(view)
            half = both[:, eye * width : (eye + 1) * width]
            self.assertGreaterEqual(psnr(view["picture"], half[place]), 50)
        self.assertLess(psnr(frame["views"][0]["picture"][:200, :200], frame["views"][1]["picture"][:200, :200]), 30)

    def play_of(self, head, view, method):
        """Both eyes' covering pictures, as `play` makes them of the same head."""
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        (width, height), fov, _ = self.covering(view)
        rows = ["time_s,x_m,y_m,z_m,qw,qx,qy,qz", ",".join(f"{x:.9g}" for x in (0, *head))]
        (out / "head.csv").write_text("\n".join(rows) + "\n")
        PROGRAMS.run("play", self.stream, "--scene", self.scene, "--depth", "gl", "--method", method, "--size", f"{width}x{height}", "--fov", f"{fov:.9g}", "--ipd",
                     IPD_M, "--head", out / "head.csv", "--progress", "none", "--out", out)
        return [np.asarray(Image.open(out / eye / "frame.0000.png").convert("RGB")).astype(float) for eye in ("left", "right")]

    def test_eyes_are_where_the_head_path_has_them(self):
        heads = [(0.1, 0.05, -0.1, *turn(25, (0, 1, 0))), (-0.12, 0, 0.08, *turn(-20, (1, 0, 0)))]
        for method, least_db in (("rotation", 50), ("eye-depth", 40)):
            frames, _, _ = self.worn([*heads, "exit"], "--method", method)
            for number, head in enumerate(heads):
                played = self.play_of(self.in_the_world(head), frames[number]["views"][0], method)
                for eye, view in enumerate(frames[number]["views"]):
                    _, _, place = self.covering(view)
                    with self.subTest(method=method, head=number, eye=eye):
                        self.assertGreaterEqual(psnr(view["picture"], played[eye][place]), least_db)
        self.assertLess(psnr(frames[0]["views"][0]["picture"], frames[1]["views"][0]["picture"]), 25)

    def in_the_world(self, head):
        """A head in the headset's space, which is centred where the frame's own head is."""
        middle = json.loads(PROGRAMS.run("info", self.stream, "--json"))["tracks"][0]["first_frame"]["head"]
        (a, *u), (b, *v) = middle["orientation_wxyz"], head[3:]
        u, v = np.array(u), np.array(v)
        position = np.array(middle["position_m"]) + rotation(middle["orientation_wxyz"]) @ np.array(head[:3])
        return (*position, a * b - u @ v, *(a * v + b * u + np.cross(u, v)))

    def test_eyes_that_look_apart(self):
        cant = 10
        for method, max_different in (("rotation", 0.01), ("eye-depth", 0.25)):
            frames, _, _ = self.worn([f"cant {cant}", STILL, "exit"], "--method", method)
            for eye, view in enumerate(frames[0]["views"]):
                side = 1 if eye else -1
                turned = turn(-side * cant, (0, 1, 0))
                self.assertLess(np.abs(np.array(view["orientation"]) - turned).max(), 1e-5)
                # `play` has both eyes look where its head does: one whose eye of this side is there.
                middle = np.array([side * IPD_M / 2, 0, 0]) - rotation(turned) @ [side * IPD_M / 2, 0, 0]
                played = self.play_of(self.in_the_world((*middle, *turned)), view, method)[eye]
                # Depth drawn for eyes that look farther apart has other samples at outlines, of which plants have many.
                different = np.abs(view["picture"] - played[self.covering(view)[2]]).max(axis=2) > 8
                self.assertLess(different.mean(), max_different, (method, eye))

    def test_fields_of_view_that_change(self):
        frames, log, _ = self.worn([STILL, "fov 20 15 13 19", STILL, STILL, "fov 17 13 14 18", STILL, "exit"], "--method", "rotation")
        self.assertEqual(log.end["swapchains"], 3)
        for number, tangents in ((0, (17, 13, 14, 18)), (1, (20, 15, 13, 19)), (3, (17, 13, 14, 18))):
            views = frames[number]["views"]
            played = self.play_of(self.in_the_world(STILL), views[0], "sphere")
            for eye, view in enumerate(views):
                out, inside, up, down = np.array(tangents) / 16
                seen = np.tan(view["fov"]) * (1, 1, 1, -1)
                wanted = (-inside, out, up, down) if eye else (-out, inside, up, down)
                _, _, place = self.covering(view)
                # No less than is asked for, and less than a pixel more.
                focal = view["rect"][2] / (seen[1] - seen[0])
                self.assertTrue((np.abs(seen) >= np.abs(wanted) - 1e-4).all())
                self.assertTrue((np.abs(seen) <= np.abs(wanted) + 1.1 / focal).all())
                self.assertGreaterEqual(psnr(view["picture"], played[eye][place]), 50)

    def test_beyond_the_head_box_is_where_the_headsets_eyes_are(self):
        # 40 cm to lean: a head 35 cm aside is within, and so are eyes 6 cm apart; those of a giant are not.
        aside = (0.35, 0, 0, 1, 0, 0, 0)
        frames, _, _ = self.worn([aside, "ipd 0.6", aside, "exit"], "--method", "rotation")
        within, beyond = (frames[number]["views"][1]["picture"] for number in (0, 1))
        self.assertLess(beyond.std(), 0.8 * within.std())


if __name__ == "__main__":
    unittest.main()
