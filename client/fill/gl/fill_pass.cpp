#include "fill_pass.h"

#include "push_pull.h"

#include <equistream/bound.h>
#include <equistream/patches.h>

#include <client/fill/push_pull.h>
#include <client/gpu/drawing_state.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// Of points in one's axes to the other's.
glm::mat4 change(const Pose& from, const Pose& to) {
    const glm::dmat4 turn = glm::mat4_cast(glm::conjugate(to.orientation));
    return glm::mat4(glm::translate(turn, from.position_m - to.position_m) * glm::mat4_cast(from.orientation));
}

}  // namespace

FoundDepth::FoundDepth()
    : draw_("forward_depth.glsl"), draw_patches_("forward_depth.glsl", std::vector<std::string>{"PATCHES"}),
      end_("end_forward.glsl"), groups_pass_("forward_groups.glsl"), still_there_("still_there.glsl"),
      background_("background_depth.glsl"), groups_(make_buffer(3 * sizeof(GLuint), 0)) {}

void FoundDepth::size_for(const EyeTargets& targets) {
    if (targets.size() == size_ && targets.eyes() == eyes_)
        return;
    keys_ = make_layered_texture(targets.size(), targets.eyes(), GL_R32I);
    size_ = targets.size();
    eyes_ = targets.eyes();
    const GLint none = std::numeric_limits<GLint>::min();
    glClearTexImage(keys_.name(), 0, GL_RED_INTEGER, GL_INT, &none);
}

void FoundDepth::start(const GapTargets& to, GLuint depth) {
    size_for(to.targets);
    to.gaps.bind();
    glBindTextureUnit(1, depth);
    glBindTextureUnit(3, to.targets.origin());
    glBindImageTexture(0, keys_.name(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32I);
}

/// Into groups_, for passes over all samples in so many layers, or, if there are no gaps, over none.
void FoundDepth::count_groups(Size samples, int layers, const GapTargets& to) const {
    to.gaps.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, groups_.name());
    groups_pass_.set("groups_with_gaps", glm::ivec3((samples.width + group_width - 1) / group_width,
                                                    (samples.height + group_height - 1) / group_height, layers));
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    groups_pass_.use();
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT);
}

void FoundDepth::draw_picture(const OtherPicture& from, const GapTargets& to, GLuint depth) {
    blocks_.set(from.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, from.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    start(to, depth);
    count_groups(from.textures.size(), eyes_, to);
    draw_.dispatch_indirect(groups_.name(), 0);
    end(to);
}

void FoundDepth::draw_forward(const OtherPicture& from, const GapTargets& to) {
    assert(from.textures.depth() != 0);
    draw_picture(from, to, from.textures.depth());
}

void FoundDepth::draw_still_there(const OtherPicture& earlier, const OtherPicture& main, const GapTargets& to) {
    assert(earlier.textures.depth() != 0 && main.textures.depth() != 0);
    const Size size = earlier.textures.size();
    if (!(size == earlier_size_)) {
        earlier_depth_ = make_texture(size, GL_R32F);
        earlier_size_ = size;
    }
    double radius_m = main.view.box_radius_m;
    for (const EyeView& eye : to.eyes)
        radius_m = std::max(radius_m, glm::distance(main.view.pose.position_m, eye.pose.position_m));
    const double tolerance_rad = error_budget_rad(to.eyes.front().camera.focal_px());
    still_there_.set("main_from_source", change(earlier.view.pose, main.view.pose));
    still_there_.set("joins", glm::vec2(radius_m, std::sin(tolerance_rad)));
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, earlier.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 2, main.textures.grid());
    glBindTextureUnit(1, earlier.textures.depth());
    glBindTextureUnit(4, main.textures.depth());
    glBindImageTexture(0, earlier_depth_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    count_groups(size, 1, to);
    still_there_.dispatch_indirect(groups_.name(), 0);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    draw_picture(earlier, to, earlier_depth_.name());
}

void FoundDepth::draw_forward(const PatchesView& patches, const PatchTextures& textures, const GapTargets& to) {
    assert(textures.atlas().depth() != 0);
    start(to, textures.atlas().depth());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, textures.grid());
    glBindTextureUnit(4, textures.slots());
    draw_patches_.set("block_side", patches.atlas->block_side);
    draw_patches_.set("slot_columns", patches.atlas->columns);
    count_groups({patches.atlas->sphere_width, patches.atlas->sphere_height}, eyes_, to);
    for (int i = 0; i < int(patches.atlas->offsets_m.size()); ++i) {
        std::array<Pose, max_eyes> poses;
        poses.fill(patch_sphere_pose(patches, i));
        blocks_.set(std::span(poses).first(to.eyes.size()), patches.box_radius_m, to.eyes);
        glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
        draw_patches_.set("patch_spheres", glm::ivec2(i));
        draw_patches_.dispatch_indirect(groups_.name(), 0);
    }
    end(to);
}

void FoundDepth::forget(const GapTargets& to) {
    start(to, 0);
    end(to);
}

void FoundDepth::end(const GapTargets& to) {
    assert(to.depth.scale == 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glBindImageTexture(1, to.depth.texture, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    to.gaps.dispatch(end_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void FoundDepth::find_background(const SourceView& main, const GapTargets& to) {
    assert(to.depth.scale == 1);
    blocks_.set(main, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    to.gaps.bind();
    glBindTextureUnit(3, to.targets.origin());
    glBindImageTexture(0, to.depth.texture, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32F);
    to.gaps.dispatch(background_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

// The passes themselves: which picture each looks up in, and by whose depth.

namespace {

/// What gap pixels see in mirrors and glass: by what an earlier picture tells itself, else by the main one.
GapTargets with_mirrors(const GlFillFrame& frame, const std::optional<SpecularSource>& own, const GapTargets& to) {
    GapTargets with = to;
    with.image_behind = frame.gap_mirrors->find(own && own->tells() ? *own : frame.mirrors, to);
    return with;
}

class PicturePass : public GlFillPass {
public:
    explicit PicturePass(GlFillShared& shared) : resample_(shared.resample()) {}

protected:
    /// From a picture with depth; where it or the eyes have none, by direction alone what may be (GapResample).
    void resample(const GlFillFrame& frame, const std::optional<OtherPicture>& from, const GapTargets& to) {
        if (!from)
            return;
        if (from->textures.depth() == 0 || to.depth.texture == 0) {
            if (frame.found != nullptr && to.depth.texture != 0)
                frame.found->forget(to);
            resample_.fill(*from, to);
        } else {
            if (frame.found != nullptr)
                frame.found->draw_forward(*from, to);
            resample_.fill(*from, with_mirrors(frame, {}, to));
        }
    }

    GapResample& resample_;
};

class HiddenPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "hidden"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override { resample(frame, frame.hidden, to); }
};

class SmallPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "small"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override { resample(frame, frame.small, to); }
};

/// While it lives, nothing is drawn or dispatched where a query found nothing. The CPU need not know.
class WhereFound {
public:
    explicit WhereFound(const Query& query) { glBeginConditionalRender(query.name(), GL_QUERY_WAIT); }
    ~WhereFound() { glEndConditionalRender(); }
    WhereFound(const WhereFound&) = delete;
    WhereFound& operator=(const WhereFound&) = delete;
};

/// What eyes see of the sphere around their window: beyond its border, and mixed along it so that no border is seen.
class BasePass : public GlFillPass {
public:
    BasePass();
    std::string_view name() const override { return "base"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override;

private:
    void find_border(const GlFillFrame& frame, const GapTargets& to);
    void ask_whether_it_is_seen(const EyeTargets& targets) const;
    void take(const GlFillFrame& frame, const SeenBase& base, const GapTargets& to) const;
    void look_at_window(const GlFillFrame& frame, const GapTargets& to, const Program& program) const;

    GapTiles border_;
    Program take_, point_;
    VertexArray no_vertices_;
    EyeBlocks blocks_;
    Query is_seen_;
    Size base_size_, eye_size_;  ///< that all is made for
    int eyes_ = 0;
};

BasePass::BasePass()
    : border_(Program("window_border.glsl", std::vector<std::string>{"FIND"})), take_("window_border.glsl"),
      point_({{GL_VERTEX_SHADER, {}, "void main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); gl_PointSize = 1.0; }"},
              {GL_FRAGMENT_SHADER, {}, "void main() {}"}}),
      no_vertices_(make_vertex_array()) {
    GLuint name = 0;
    glCreateQueries(GL_ANY_SAMPLES_PASSED, 1, &name);
    is_seen_ = Query(name);
}

void BasePass::look_at_window(const GlFillFrame& frame, const GapTargets& to, const Program& program) const {
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame.main.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, to.targets.origin());
    glBindTextureUnit(2, to.depth.texture);
    program.set("inverse_depth_scale", to.depth.texture != 0 ? to.depth.scale : 0.0f);
}

void BasePass::find_border(const GlFillFrame& frame, const GapTargets& to) {
    look_at_window(frame, to, border_.finder());
    border_.finder().set("knows_gaps", int(frame.found == nullptr));
    border_.find(to.targets);
}

/// Whether any pixel lies along the window's border or beyond it: whether any of its screen tiles was listed.
void BasePass::ask_whether_it_is_seen(const EyeTargets& targets) const {
    write_all_pixels();
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glBindFramebuffer(GL_FRAMEBUFFER, targets.framebuffer());
    glViewport(0, 0, 1, 1);
    glBindVertexArray(no_vertices_.name());
    point_.use();
    glBeginQuery(GL_ANY_SAMPLES_PASSED, is_seen_.name());
    border_.draw_points(GapTiles::List::with_gaps);
    glEndQuery(GL_ANY_SAMPLES_PASSED);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void BasePass::take(const GlFillFrame& frame, const SeenBase& base, const GapTargets& to) const {
    // By the scene's geometry gaps have a depth of their own.
    const bool finds_depth = frame.found != nullptr && to.depth.texture != 0;
    const EyeDepth& depth = frame.found != nullptr ? base.depth : to.depth;
    look_at_window(frame, to, take_);
    glBindTextureUnit(1, base.targets.colour());
    glBindTextureUnit(3, base.targets.origin());
    glBindTextureUnit(4, depth.texture);
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA8);
    glBindImageTexture(1, to.targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    if (finds_depth)
        glBindImageTexture(2, to.depth.texture, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    take_.set("base_depth_scale", depth.texture != 0 ? depth.scale : 0.0f);
    take_.set("finds_depth", int(finds_depth));
    take_.set("knows_mirrors", int(frame.mirrors.tells()));
    if (frame.mirrors.tells())
        frame.mirrors.specular.bind();
    for (const bool fills_gaps : {false, true}) {
        const GapTiles& tiles = fills_gaps ? to.gaps : border_;
        take_.set("fills_gaps", int(fills_gaps));
        tiles.bind();
        tiles.dispatch(take_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    }
    finish_pictures();
}

void BasePass::fill(const GlFillFrame& frame, const GapTargets& to) {
    if (!frame.base)
        return;
    blocks_.set(frame.main.view, to.eyes);
    find_border(frame, to);
    // Of other sizes all is made, and an engine asks the GPU how much room it needs.
    const Size size = frame.base->textures.size();
    const bool all_is_made = size == base_size_ && to.targets.size() == eye_size_ && to.targets.eyes() == eyes_;
    ask_whether_it_is_seen(to.targets);
    std::optional<WhereFound> where_seen;
    if (all_is_made)
        where_seen.emplace(is_seen_);
    eyes_ = 0;  // what fails half-way is begun anew
    const SeenBase base = frame.see_base();
    if (!where_seen)
        where_seen.emplace(is_seen_);
    take(frame, base, to);
    base_size_ = size;
    eye_size_ = to.targets.size();
    eyes_ = to.targets.eyes();
}

class EarlierPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "earlier"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override;

private:
    static void find_still_there(const GlFillFrame& frame, const OtherPicture& from, const GapTargets& to);

    SeenLight light_;
};

void EarlierPass::find_still_there(const GlFillFrame& frame, const OtherPicture& from, const GapTargets& to) {
    if (frame.found == nullptr)
        return;
    if (frame.main.textures.depth() != 0)
        frame.found->draw_still_there(from, frame.main, to);
    else
        frame.found->draw_forward(from, to);
}

void EarlierPass::fill(const GlFillFrame& frame, const GapTargets& to) {
    if (to.depth.texture == 0)
        return;
    if (frame.earlier && frame.earlier->textures.depth() != 0) {
        find_still_there(frame, *frame.earlier, to);
        resample_.fill(*frame.earlier, with_mirrors(frame, frame.mirrors_earlier, to));
    }
    for (const LeftPicture& left : frame.left) {
        if (!frame.base || left.window.textures.depth() == 0)
            continue;
        find_still_there(frame, left.window, to);
        GapTargets with = with_mirrors(frame, left.mirrors, to);
        light_.find(left.base, *frame.base, with);
        resample_.fill(left.window, with);
    }
}

class PatchesPass : public GlFillPass {
public:
    std::string_view name() const override { return "patches"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override {
        if (to.depth.texture == 0 || frame.patch_textures == nullptr || frame.patch_textures->atlas().depth() == 0)
            return;
        if (frame.found != nullptr)
            frame.found->draw_forward(*frame.patches, *frame.patch_textures, to);
        resample_.fill(*frame.patches, *frame.patch_textures, with_mirrors(frame, {}, to));
    }

private:
    PatchResample resample_;
};

class PushPullPass : public GlFillPass {
public:
    std::string_view name() const override { return "pushpull"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override {
        if (to.depth.texture != 0 && frame.found != nullptr)
            frame.found->find_background(frame.main.view, to);
        push_pull_.fill(frame.main.view, to.eyes, to.depth, to.gaps, to.targets);
    }

private:
    PushPull push_pull_;
};

}  // namespace

std::unique_ptr<GlFillPass> make_gl_base_pass(GlFillShared&) {
    return std::make_unique<BasePass>();
}

std::unique_ptr<GlFillPass> make_gl_hidden_pass(GlFillShared& shared) {
    return std::make_unique<HiddenPass>(shared);
}

std::unique_ptr<GlFillPass> make_gl_small_pass(GlFillShared& shared) {
    return std::make_unique<SmallPass>(shared);
}

std::unique_ptr<GlFillPass> make_gl_earlier_pass(GlFillShared& shared) {
    return std::make_unique<EarlierPass>(shared);
}

std::unique_ptr<GlFillPass> make_gl_patches_pass(GlFillShared&) {
    return std::make_unique<PatchesPass>();
}

std::unique_ptr<GlFillPass> make_gl_push_pull_pass(GlFillShared&) {
    return std::make_unique<PushPullPass>();
}

GapResample& GlFillShared::resample() {
    if (!resample_)
        resample_.emplace();
    return *resample_;
}

}  // namespace equistream::gl
