# %% [markdown]
# # A room as a sphere, with depth
# Cells of a notebook; Python runs them in order too. The first two lines make the plugins found: the folder is the one
# that holds `plugins/equirect.so`, here the first argument or EQUISTREAM_BUILD.

# %%
import os
import sys

import mitsuba as mi
import numpy as np

mi.set_variant(os.environ.get("VARIANT", "llvm_ad_rgb"))
mi.file_resolver().append(sys.argv[1] if len(sys.argv) > 1 else os.environ["EQUISTREAM_BUILD"])

# %% [markdown]
# Any scene will do: exchange its sensor and its integrator. The camera looks along +Z of its own frame.

# %%
scene = mi.cornell_box()
scene["sensor"] = {
    "type": "equirect",
    "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 0.2], target=[0, 0, -1], up=[0, 1, 0]),
    "film": {"type": "hdrfilm", "width": 256, "height": 128, "component_format": "float32",
             "rfilter": {"type": "gaussian"}},
    "sampler": {"type": "independent", "sample_count": 64},
}
scene["integrator"] = {"type": "equirect_aov", "aovs": "depth,motion,normal,ids", "nested": scene["integrator"]}
scene = mi.load_dict(scene)

# %% [markdown]
# One picture holds colour and the planes. Their names say which is which.

# %%
image = np.array(mi.render(scene))
names = scene.integrator().aov_names()
planes = dict(zip(names, np.moveaxis(image[..., -len(names):], -1, 0)))
print(f"{image.shape[1]}x{image.shape[0]} pixels, {len(names)} planes beside colour: {', '.join(names)}")
print(f"nearest wall {planes['depth.Z'].min():.3f}, farthest corner {planes['depth.Z'].max():.3f}")

# %% [markdown]
# The next frame: the camera moves 5 cm forward, and motion says where everything was before.

# %%
params = mi.traverse(scene)
params["sensor.to_world_previous"] = params["sensor.to_world"]
params["sensor.to_world"] = mi.ScalarTransform4f().look_at(origin=[0, 0, 0.15], target=[0, 0, -1], up=[0, 1, 0])
params.update()
mi.render(scene, seed=1)
image = np.array(scene.sensors()[0].film().develop())
planes = dict(zip(names, np.moveaxis(image[..., -len(names):], -1, 0)))
# Walking ahead, one sees things at the sides fall back: before, they were nearer to the middle.
left, right = planes["backward.u"][64, 64], planes["backward.u"][64, 192]
print(f"what is seen at the left came from {left:+.2f} columns away; at the right, from {right:+.2f}")

# %% [markdown]
# All of it as one EXR, channels named as equistream names them.

# %%
out = sys.argv[2] if len(sys.argv) > 2 else "sphere.exr"
scene.sensors()[0].film().write(out)
print(f"written: {out}")
