#include "fill.h"
#include "forward_depth.h"
#include "gap_resample.h"
#include "gaps.h"

#include <equistream/bound.h>
#include <equistream/depth_agreement.h>
#include <equistream/patches.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace equistream {

namespace {

/// Where an eye has no depth, `still_there` says which samples may be drawn forward.
std::int64_t fill_from(const SourceView& source, const GapResampleTask& task, SeenPoints& seen, EyePicture& picture,
                       const StillThere& still_there) {
    const PictureGrid grid(source);
    if (task.eye.depth_m.data == nullptr) {
        const ForwardTask forward{task.eye, task.gaps, picture, seen, task.error_budget_px};
        draw_forward(grid, forward, still_there);
        end_drawing(forward);
    }
    return resample_gaps(grid, task, picture);
}

/// Looks gap pixels up in pictures that were rendered elsewhere.
class PicturePass : public FillPass {
public:
    explicit PicturePass(std::string_view name) : FillPass(name, true) {}

protected:
    std::int64_t fill_from_one(const SourceView* source, PixelOrigin mark, const EyeView& eye, EyePicture& picture,
                               Gaps& gaps) const {
        if (source == nullptr || source->depth_m.data == nullptr || gaps.empty())
            return 0;
        std::unique_ptr<SeenPoints> seen = pool_.acquire();
        seen->look(eye, picture, gaps);
        const GapResampleTask task{eye, *seen, gaps, inputs_.error_budget_px, mark, inputs_.main};
        const std::int64_t filled = fill_from(*source, task, *seen, picture, {});
        pool_.release(std::move(seen));
        gaps.narrow(picture.origin.view());
        return filled;
    }

    /// The same, or by direction alone where the source has no depth.
    std::int64_t fill_by_any(const SourceView& source, PixelOrigin mark, const EyeView& eye, EyePicture& picture,
                             Gaps& gaps) const {
        if (source.depth_m.data != nullptr)
            return fill_from_one(&source, mark, eye, picture, gaps);
        const SeenPoints nothing;
        const GapResampleTask task{eye, nothing, gaps, inputs_.error_budget_px, mark};
        const std::int64_t filled = resample_gaps_by_direction(PictureGrid(source), task, picture);
        gaps.narrow(picture.origin.view());
        return filled;
    }

    mutable ObjectPool<SeenPoints> pool_;
};

/// A surface that the source looks through now is not there any more.
class SeenThrough {
public:
    SeenThrough(const SourceView& main, const EyeView& eye, double error_budget_px)
        : main_(main), grid_(source_grid(main.camera)),
          agreement_{float(std::max(main.box_radius_m, glm::distance(main.pose.position_m, eye.pose.position_m))),
                     float(std::sin(error_budget_rad(eye.camera.focal_px(), error_budget_px)))} {}

    bool still_there(const glm::dvec3& point_world) const {
        const glm::dvec3 d = glm::conjugate(main_.pose.orientation) * (point_world - main_.pose.position_m);
        const glm::dvec2 pixel = glm::floor(pixel_of(main_.camera, d));
        if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < width_of(main_.camera) && pixel.y < height_of(main_.camera)))
            return true;
        const float clearance = agreement_.clearance(float(glm::length(d)));
        // Somewhere around the pixel, for the point may lie on a slope or at an edge.
        for (int k = 0; k < 9; ++k) {
            const Sample s = wrapped(grid_, int(pixel.x) + k % 3 - 1, int(pixel.y) + k / 3 - 1);
            const float now = agreement_.clearance(main_.depth_m.pixel(s.x, s.y)[0]);
            if (now <= clearance || agreement_.same(now, clearance))
                return true;
        }
        return false;
    }

private:
    const SourceView& main_;
    SourceGrid grid_;
    DepthAgreement agreement_;
};

bool has_colour(const SourceView& view) {
    return view.rgb.data != nullptr || view.yuv.y.data != nullptr;
}

/// Where light has changed since an earlier window was rendered: by the coarse spheres around that one and today's.
class ChangedLight {
public:
    ChangedLight(const SourceView& then, const SourceView& now, const EyeView& eye, const SeenPoints& seen)
        : then_(then, eye), now_(now, eye), seen_(seen) {}

    bool at(int x, int y) const {
        const float inverse = seen_.inverse_planar.pixel(x, y)[0];
        const glm::vec3 apart = abs(then_.colour(x, y, inverse) - now_.colour(x, y, inverse));
        return std::max({apart.x, apart.y, apart.z}) > changed_light;
    }

private:
    class Base {
    public:
        Base(const SourceView& view, const EyeView& eye)
            : view_(view), lookup_(view.camera), rays_(eye.camera, eye.pose, view.pose) {}

        glm::vec3 colour(int x, int y, float inverse) const {
            // Over a few samples, for they are noisy where light is not denoised.
            const PixelPosition middle = lookup_.project(rays_.direction(x, y) + rays_.eye() * inverse);
            glm::vec3 sum(0);
            for (const float v : {-1.0f, 1.0f})
                for (const float u : {-1.0f, 1.0f}) {
                    const float row = std::clamp(middle.v + v, 0.0f, float(lookup_.grid().height));
                    const Taps taps = lookup_.taps({middle.u + u, row});
                    for (int k = 0; k < 4; ++k)
                        sum += 0.25f * taps.weight[k] * sample_colour(view_.rgb, view_.yuv, taps.x[k], taps.y[k]);
                }
            return sum;
        }

    private:
        const SourceView& view_;
        SourceLookup lookup_;
        EyeRays rays_;
    };

    Base then_, now_;
    const SeenPoints& seen_;
};

/// The small second-eye view.
class SmallPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override {
        if (inputs_.small == nullptr || gaps.empty())
            return 0;
        return fill_by_any(*inputs_.small, PixelOrigin::small, eye, picture, gaps);
    }
};

/// The same; what it does not resolve is left to others.
class SmallWidePass : public SmallPass {
public:
    using SmallPass::SmallPass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override {
        if (inputs_.small == nullptr || gaps.empty())
            return 0;
        Gaps wide = wide_gaps(gaps, eye.camera.width, wide_gap_side(eye.camera, inputs_.small->camera));
        const std::int64_t filled = fill_by_any(*inputs_.small, PixelOrigin::small, eye, picture, wide);
        gaps.narrow(picture.origin.view());
        return filled;
    }
};

/// The source's second layer.
class HiddenPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override {
        return fill_from_one(inputs_.hidden, PixelOrigin::hidden, eye, picture, gaps);
    }
};

/// Earlier main pictures, the newest first.
class EarlierPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;
};

/// Blocks of spheres beside the source's.
class PatchesPass : public PicturePass {
public:
    using PicturePass::PicturePass;
    void set_frame(const FillInputs& inputs) override;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    std::optional<PatchSlots> slots_;  ///< of the inputs' atlas
};

std::int64_t EarlierPass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    StillThere still_there;
    const SourceView* main = inputs_.main;
    const double budget_px = inputs_.error_budget_px;
    if (main != nullptr && main->depth_m.data != nullptr)
        still_there = [through = SeenThrough(*main, eye, budget_px)](const glm::dvec3& p) {
            return through.still_there(p);
        };
    std::unique_ptr<SeenPoints> seen = pool_.acquire();
    std::int64_t filled = 0;
    for (std::size_t i = 0; i < inputs_.earlier.size(); ++i) {
        const SourceView& source = inputs_.earlier[i];
        if (gaps.empty())
            break;
        if (source.depth_m.data == nullptr)
            continue;
        seen->look(eye, picture, gaps);
        GapResampleTask task{eye, *seen, gaps, budget_px, PixelOrigin::earlier, main};
        std::optional<ChangedLight> changed;
        if (inputs_.base != nullptr && i < inputs_.earlier_bases.size() && has_colour(inputs_.earlier_bases[i])) {
            changed.emplace(inputs_.earlier_bases[i], *inputs_.base, eye, *seen);
            task.is_outdated = [&](int x, int y) { return changed->at(x, y); };
        }
        filled += fill_from(source, task, *seen, picture, still_there);
        gaps.narrow(picture.origin.view());
    }
    pool_.release(std::move(seen));
    return filled;
}

void PatchesPass::set_frame(const FillInputs& inputs) {
    inputs_ = inputs;
    slots_.reset();
    if (inputs.patches != nullptr && inputs.patches->depth_m.data != nullptr)
        slots_.emplace(*inputs.patches->atlas);
}

std::int64_t PatchesPass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (!slots_ || gaps.empty())
        return 0;
    const PatchesView& patches = *inputs_.patches;
    const double budget_px = inputs_.error_budget_px;
    std::vector<std::unique_ptr<PatchGrid>> grids;
    for (std::size_t offset = 0; offset < patches.atlas->offsets_m.size(); ++offset)
        grids.push_back(std::make_unique<PatchGrid>(patches, *slots_, int(offset)));
    // What the eye sees is seen most alike from the sphere that is nearest to it.
    std::ranges::sort(grids, {},
                      [&](const auto& grid) { return glm::distance(grid->pose().position_m, eye.pose.position_m); });
    std::unique_ptr<SeenPoints> seen = pool_.acquire();
    seen->look(eye, picture, gaps);
    if (eye.depth_m.data == nullptr) {
        const ForwardTask forward{eye, gaps, picture, *seen, budget_px};
        for (const auto& grid : grids)
            draw_forward(*grid, forward);
        end_drawing(forward);
    }
    std::int64_t filled = 0;
    for (const bool unmixed_only : {true, false})
        for (const auto& grid : grids) {
            if (gaps.empty())
                break;
            const GapResampleTask task{eye, *seen, gaps, budget_px, PixelOrigin::patches, inputs_.main, unmixed_only};
            filled += resample_gaps(*grid, task, picture);
            gaps.narrow(picture.origin.view());
        }
    pool_.release(std::move(seen));
    return filled;
}

}  // namespace

std::unique_ptr<FillPass> make_hidden_pass() {
    return std::make_unique<HiddenPass>("hidden");
}

std::unique_ptr<FillPass> make_earlier_pass() {
    return std::make_unique<EarlierPass>("earlier");
}

std::unique_ptr<FillPass> make_patches_pass() {
    return std::make_unique<PatchesPass>("patches");
}

std::unique_ptr<FillPass> make_small_pass() {
    return std::make_unique<SmallPass>("small");
}

std::unique_ptr<FillPass> make_small_wide_pass() {
    return std::make_unique<SmallWidePass>("small-wide");
}

FilledCounts fill_gaps(const FillChain& chain, const EyeView& eye, EyePicture& picture) {
    FilledCounts filled;
    Gaps gaps(picture.origin.view());
    for (const auto& pass : chain)
        filled.emplace_back(pass->name(), pass->fill(eye, picture, gaps));
    return filled;
}

}  // namespace equistream
