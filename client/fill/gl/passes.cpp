/// The passes themselves: which picture each looks up in, and by whose depth.
#include "fill_pass.h"
#include "push_pull.h"

namespace equistream::gl {

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
    /// From a picture with depth; of a small one without, by direction alone.
    void resample(const GlFillFrame& frame, const OtherPicture& from, const GapTargets& to) {
        if (from.textures.depth() == 0) {
            resample_.fill(from, to);
            return;
        }
        if (frame.found != nullptr)
            frame.found->draw_forward(from, to);
        resample_.fill(from, with_mirrors(frame, {}, to));
    }

    GapResample& resample_;
};

class HiddenPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "hidden"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override {
        if (to.depth.texture != 0 && frame.hidden)
            resample(frame, *frame.hidden, to);
    }
};

class SmallPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "small"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override {
        if (frame.small && (to.depth.texture != 0 || frame.small->textures.depth() == 0))
            resample(frame, *frame.small, to);
    }
};

class EarlierPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::string_view name() const override { return "earlier"; }
    void fill(const GlFillFrame& frame, const GapTargets& to) override {
        if (to.depth.texture == 0 || !frame.earlier)
            return;
        const OtherPicture& from = *frame.earlier;
        if (from.textures.depth() == 0) {
            resample_.fill(from, to);
            return;
        }
        if (frame.found != nullptr && same_camera(from.view.camera, frame.main.view.camera))
            frame.found->draw_still_there(from, frame.main, to);
        else if (frame.found != nullptr)
            frame.found->forget(to);
        resample_.fill(from, with_mirrors(frame, frame.mirrors_earlier, to));
    }
};

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
