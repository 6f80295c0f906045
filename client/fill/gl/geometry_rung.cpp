#include "geometry_rung.h"

#include "../geometry_light.h"
#include "../push_pull_pyramid.h"

#include <equistream/formatted.h>

#include <array>
#include <cassert>
#include <string>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

static_assert(light_tile_side == PullPyramid::tile_side);

std::vector<std::string> light_defines() {
    return {formatted("LIT_TILES_AROUND %d", lit_tiles_around),
            formatted("LIGHT_SAMPLE_STEP %d", light_sample_step),
            formatted("FARTHEST_LIGHT_TILE %d", farthest_light_tile),
            formatted("ENOUGH_LIGHT_SAMPLES %d", int(enough_light_samples)),
            formatted("LEAST_BASE %.9g", double(least_base)),
            formatted("LEAST_LIGHT_WEIGHT %.9g", double(least_light_weight))};
}

std::vector<std::string> shading_defines() {
    std::vector<std::string> all = light_defines();
    for (auto& more : {SceneGeometry::defines(), SurfaceColours::defines()})
        all.insert(all.end(), more.begin(), more.end());
    return all;
}

}  // namespace

GeometryRung::GeometryRung(const SceneModel& model)
    : colours_(model), wanted_({{GL_COMPUTE_SHADER, "wanted_tiles.glsl"}}, light_defines()),
      shade_({{GL_COMPUTE_SHADER, "shade_surfaces.glsl"}}, shading_defines()),
      fill_({{GL_COMPUTE_SHADER, "geometry_rung.glsl"}}, light_defines()) {}

void GeometryRung::size_for(const GapTargets& to) {
    if (to.targets.size() == size_ && to.targets.eyes() == eyes_)
        return;
    size_ = to.targets.size();
    eyes_ = to.targets.eyes();
    wanted_tiles_ = make_layered_texture(to.gaps.grid(), eyes_, GL_R8UI);
    surfaces_seen_ = make_layered_texture(size_, eyes_, GL_RGBA32UI);
}

void GeometryRung::shade(const DepthPass& drawn, const GapTargets& to) {
    std::array<Pose, most_eyes> world;
    blocks_.set(std::span(world).first(to.eyes.size()), 0, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    drawn.geometry().bind();
    colours_.bind();
    glBindTextureUnit(0, drawn.triangles());
    glBindTextureUnit(1, wanted_tiles_.name());
    glBindTextureUnit(3, to.targets.origin());
    glBindImageTexture(0, surfaces_seen_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    shade_.set("spread_rad", float(to.eyes.front().camera.pixel_angle_rad()));
    shade_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void GeometryRung::fill(const DepthPass& drawn, const GapTargets& to) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    size_for(to);
    to.gaps.bind();
    glBindImageTexture(0, wanted_tiles_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    wanted_.dispatch(to.gaps.grid(), eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    shade(drawn, to);
    to.gaps.bind();
    glBindTextureUnit(0, surfaces_seen_.name());
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA8);
    glBindImageTexture(1, to.targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    to.gaps.dispatch(fill_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace equistream::gl
