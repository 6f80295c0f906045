#include "reliability_map.h"

#include <client/confidence/coefficients.h>
#include <client/confidence/reliability.h>
#include <client/fill/push_pull.h>

#include <equistream/visible_loss.h>

#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

constexpr int origin_words = 12;
constexpr int weight_places = 16;
static_assert(pixel_origin_count <= origin_words && risk_count <= weight_places && VisibleLoss::textures.size() == 8);

/// As std140 has it (map_numbers.glsl).
struct EyeNumbers {
    glm::vec4 centre, pole, eye, more;
    glm::ivec4 reach;
    std::array<GLint, origin_words> group_of_origin{};
};
struct MapNumbers {
    std::array<EyeNumbers, max_eyes> eyes;
    std::array<std::array<GLfloat, weight_places>, risk_group_count> weights{};
    std::array<GLfloat, VisibleLoss::textures.size()> losses;
};

EyeNumbers eye_numbers(const RiskNumbers& n, bool has_depth, bool untouched) {
    EyeNumbers numbers{{n.centre.x, n.centre.y, n.centre.z, n.baseline_m},
                       {n.pole.x, n.pole.y, n.pole.z, n.density},
                       {n.focal_px, n.outside, n.depth_error_px, n.min_step_inverse_m},
                       {std::log2(n.density), untouched ? 1.0f : 0.0f, 0, 0},
                       {n.step, n.texture_reach, has_depth, n.mirrors}};
    for (int origin = 1; origin < pixel_origin_count; ++origin)
        numbers.group_of_origin[std::size_t(origin)] = int(risk_group(PixelOrigin(origin), n.known));
    return numbers;
}

Texture uploaded_shares() {
    using namespace reliability_model;
    Texture texture = make_texture({table_size, risk_group_count}, GL_R8UI);
    for (int group = 0; group < risk_group_count; ++group)
        glTextureSubImage2D(texture.name(), 0, 0, group, table_size, 1, GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                            groups[std::size_t(group)].share_255.data());
    return texture;
}

void write_to(const Texture& texture, GLenum format) {
    glBindImageTexture(0, texture.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, format);
}

}  // namespace

ReliabilityMap::ReliabilityMap()
    : surroundings_pass_("map_surroundings.glsl"), rows_pass_("map_rows.glsl"),
      column_steps_pass_("map_fill_depth.glsl"),
      fill_depth_pass_("map_fill_depth.glsl", std::vector<std::string>{"ACROSS"}), map_pass_("map.glsl"),
      shares_(uploaded_shares()), numbers_(make_buffer(sizeof(MapNumbers), GL_DYNAMIC_STORAGE_BIT)) {}

void ReliabilityMap::size_for(const EyeTargets& targets) {
    if (targets.size() == size_ && targets.eyes() == eyes_)
        return;
    size_ = {};  // what fails half-way is begun anew
    eyes_ = targets.eyes();
    const auto layers = [&](GLenum format) { return make_layered_texture(targets.size(), eyes_, format); };
    surroundings_ = layers(GL_RGBA8UI);
    rows_ = layers(GL_RG16UI);
    column_steps_ = layers(GL_R8UI);
    fill_depth_ = layers(GL_R8UI);
    reliability_ = layers(GL_R8);
    size_ = targets.size();
}

void ReliabilityMap::set_numbers(const SourceView& source, const JudgedEyes& judged,
                                 const ReliabilityOptions& options) {
    MapNumbers numbers{};
    const bool has_depth = judged.depth.texture != 0;
    for (std::size_t i = 0; i < judged.eyes.size(); ++i) {
        const EyeView& eye = judged.eyes[i];
        const SourceView& own = judged.source(i, source);
        numbers.eyes[i] = eye_numbers(RiskNumbers(own, eye, has_depth, options), has_depth, same_view(own, eye));
    }
    for (std::size_t i = 0; i < numbers.weights.size(); ++i)
        std::ranges::copy(reliability_model::groups[i].weights, numbers.weights[i].begin());
    const VisibleLoss loss = options.visible_loss.value_or(VisibleLoss{});
    std::ranges::transform(VisibleLoss::textures, numbers.losses.begin(),
                           [&](float texture) { return loss_at(loss, texture); });
    glNamedBufferSubData(numbers_.name(), 0, sizeof numbers, &numbers);
}

void ReliabilityMap::find_fill_depth(const EyeTargets& targets) {
    filled_.find(targets);
    glBindTextureUnit(1, targets.origin());
    glBindTextureUnit(5, column_steps_.name());
    for (const auto& [program, to] :
         {std::pair(&column_steps_pass_, &column_steps_), std::pair(&fill_depth_pass_, &fill_depth_)}) {
        write_to(*to, GL_R8UI);
        filled_.dispatch(*program, GapTiles::List::with_gaps, PullPyramid::tile_levels);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
}

void ReliabilityMap::estimate(const SpecularSource& source, const JudgedEyes& judged,
                              const ReliabilityOptions& options) {
    const EyeTargets& targets = judged.targets;
    assert(int(judged.eyes.size()) == targets.eyes());
    size_for(targets);
    find_fill_depth(targets);
    set_numbers(source.view, judged, options);
    std::array<Pose, max_eyes> poses;
    for (std::size_t i = 0; i < judged.eyes.size(); ++i)
        poses[i] = judged.source(i, source.view).pose;
    blocks_.set(std::span(poses).first(judged.eyes.size()), source.view.box_radius_m, judged.eyes);
    const std::array uniforms = {source.textures.grid(), blocks_.name(), numbers_.name()};
    for (GLuint i = 0; i < uniforms.size(); ++i)
        glBindBufferBase(GL_UNIFORM_BUFFER, i, uniforms[i]);
    const std::array sampled = {targets.colour(), targets.origin(),   judged.depth.texture, surroundings_.name(),
                                rows_.name(),     fill_depth_.name(), shares_.name(),       source.specular.mask()};
    for (GLuint i = 0; i < sampled.size(); ++i)
        glBindTextureUnit(i, sampled[i]);
    for (const Program* program : {&surroundings_pass_, &map_pass_})
        program->set("inverse_depth_scale", judged.depth.scale);
    write_to(surroundings_, GL_RGBA8UI);
    surroundings_pass_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    write_to(rows_, GL_RG16UI);
    rows_pass_.dispatch(size_, eyes_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    write_to(reliability_, GL_R8);
    map_pass_.dispatch(size_, eyes_);
    finish_pictures();
}

void ReliabilityMap::download(int eye, EyePicture& picture) const {
    picture.reliability = ByteImage(size_.width, size_.height, 1);
    gl::download(reliability_.name(), eye, size_, {GL_RED, GL_UNSIGNED_BYTE, 1}, picture.reliability.samples().data(),
                 std::size_t(size_.width));
}

}  // namespace equistream::gl
