"""A Mitsuba scene rendered as one sphere, and what two eyes see of it. `python reproject.py [OUT.png]`"""

# %% One scene of Mitsuba's own, and the plugins
import sys

import equistream as es
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb" if "llvm_ad_rgb" in mi.variants() else "scalar_rgb")
import equistream.mitsuba as em  # noqa: E402

scene = mi.load_dict(mi.cornell_box())

# %% A sphere around a head that stands in the box's opening, with distances
head = es.Pose.look_at((0.1, 0.1, 1.2), (0, -0.2, 0))
info = es.frame_info(es.EquirectCamera(1024, 512), pose=head, ipd_m=0.063, head_radius_m=0.1, scene="cornell-box")
sphere_pose = es.eye_pose(info.camera, head)
sphere = em.render_frame(scene, sphere_pose, info.camera, spp=64, info=info)
print(sphere)

# %% What each eye sees of it: the eye's own distances come from Mitsuba's rays, colour from the sphere
eye = es.PerspectiveCamera(384, 288, np.radians(80))
depth = em.depth_source(scene)
views = {}
for name in ("left", "right"):
    views[name] = es.reproject(sphere, eye, es.eye_pose(eye, head, name, info.ipd_m), depth=depth)
    print(name, views[name])

# %% The same eye rendered, for comparison
truth = em.render_frame(scene, views["left"].pose, eye, spp=64, aovs="none")
shown = es.to_display(truth["colour"], info.exposure)
error = shown.astype(float) - views["left"].rgb
print(f"left eye against a render of it: {10 * np.log10(255**2 / np.mean(error**2)):.1f} dB")

# %% The picture: the sphere, its distances; both eyes, what the sphere had not seen (white), and the render
strip = np.zeros((256 + 288, 4 * 384, 3), np.uint8)
strip[:256, :512] = es.to_display(sphere["colour"], info.exposure)[::2, ::2]
strip[:256, 512:1024] = es.false_colour(sphere["depth"])[::2, ::2]
for column, picture in enumerate((views["left"].rgb, views["right"].rgb, 255 * np.repeat(views["right"].gaps[..., None], 3, 2), shown)):
    strip[256:, column * 384:(column + 1) * 384] = picture
if len(sys.argv) > 1:
    from PIL import Image

    Image.fromarray(strip).save(sys.argv[1])
