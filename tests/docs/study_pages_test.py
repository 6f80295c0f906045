"""The study's pages of points, in a real headless Chromium: a point is chosen from the start, a click shows another one's pictures and commands,
letters keep their size on a phone.

Exit status 77 where there is no Chromium.
"""

import sys
import unittest

from markdown import ROOT

sys.path.insert(0, str(ROOT / "tests/programs/web"))
from chromium import Chromium, Folder, find_chromium  # noqa: E402

PAGES = ROOT / "docs/results/study"
SCENES = sorted(page.stem for page in PAGES.glob("*.html"))
PHONE_PX, DESK_PX = 390, 1200
LEAST_LETTER_PX = 12
LOADED = "document.querySelectorAll('#pictures img').length >= 3 && [...document.querySelectorAll('#pictures img')].every(image => image.naturalWidth > 0)"


class StudyPages(unittest.TestCase):
    def setUp(self):
        self.server, self.browser = Folder(PAGES), Chromium()
        self.addCleanup(self.server.close)
        self.addCleanup(self.browser.close)

    def open(self, scene, width):
        self.browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width == PHONE_PX)
        self.browser.open(f"{self.server.url}{scene}.html")
        self.browser.wait_for(LOADED)

    def test_a_point_is_chosen_and_a_click_chooses_another(self):
        self.assertTrue(SCENES)
        for scene in SCENES:
            with self.subTest(scene):
                self.open(scene, DESK_PX)
                self.assertEqual(self.browser.evaluate("document.querySelectorAll('.mark.chosen').length"), 1)
                self.browser.evaluate("window.shown = [...document.querySelectorAll('#pictures img')].map(image => image.src).join(); "
                                      "document.querySelector('.mark:not(.chosen)').dispatchEvent(new MouseEvent('click', { bubbles: true }))")
                self.browser.wait_for(LOADED)
                self.assertTrue(self.browser.evaluate("[...document.querySelectorAll('#pictures img')].map(image => image.src).join() !== window.shown"))
                self.assertIn("equistream", self.browser.evaluate("document.querySelector('#detail pre').textContent"))
                self.assertEqual(self.browser.evaluate("document.querySelectorAll('.mark.chosen').length"), 1)
                self.assertEqual(self.browser.console, [])

    def test_axes_say_what_they_are(self):
        self.open(SCENES[0], DESK_PX)
        texts = "[...document.querySelectorAll('svg text')].map(text => text.textContent)"
        self.assertIn("bytes a frame", self.browser.evaluate(texts))
        self.browser.evaluate("const x = document.getElementById('x'); x.value = 'ms'; x.dispatchEvent(new Event('change'))")
        self.assertIn("client, ms a frame", self.browser.evaluate(texts))

    def test_letters_keep_their_size_on_a_phone(self):
        self.open(SCENES[0], PHONE_PX)
        self.assertLessEqual(self.browser.evaluate("document.documentElement.scrollWidth"), PHONE_PX)
        size = ("Math.min(...[...document.querySelectorAll('svg text')].map(text => parseFloat(getComputedStyle(text).fontSize) * "
                "Math.hypot(text.getScreenCTM().a, text.getScreenCTM().b)))")
        self.assertGreaterEqual(self.browser.evaluate(size), LEAST_LETTER_PX)


if __name__ == "__main__":
    if find_chromium() is None:
        print("skipped: there is no Chromium")
        sys.exit(77)
    unittest.main()
