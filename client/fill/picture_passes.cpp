#include "fill.h"
#include "forward_depth.h"
#include "gap_resample.h"
#include "gaps.h"

#include <equistream/bound.h>
#include <equistream/depth_agreement.h>
#include <equistream/patches.h>
#include <equistream/window.h>

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
        : main_(main), agreement_{
                           float(std::max(main.box_radius_m, glm::distance(main.pose.position_m, eye.pose.position_m))),
                           float(std::sin(error_budget_rad(eye.camera.focal_px(), error_budget_px)))} {}

    bool still_there(const glm::dvec3& point_world) const {
        const glm::dvec3 d = glm::conjugate(main_.pose.orientation) * (point_world - main_.pose.position_m);
        const glm::dvec2 pixel = glm::floor(pixel_of(main_.camera, d));
        if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < width_of(main_.camera) && pixel.y < height_of(main_.camera)))
            return true;
        const float clearance = agreement_.clearance(float(glm::length(d)));
        // Somewhere around the pixel, for the point may lie on a slope or at an edge.
        for (int y = std::max(int(pixel.y) - 1, 0); y <= std::min(int(pixel.y) + 1, height_of(main_.camera) - 1); ++y)
            for (int x = std::max(int(pixel.x) - 1, 0); x <= std::min(int(pixel.x) + 1, width_of(main_.camera) - 1);
                 ++x) {
                const float now = agreement_.clearance(main_.depth_m.pixel(x, y)[0]);
                if (now <= clearance || agreement_.same(now, clearance))
                    return true;
            }
        return false;
    }

private:
    const SourceView& main_;
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
        return std::max({apart.x, apart.y, apart.z}) > coding_and_noise;
    }

private:
    /// What two pictures of the same differ by, of 255.
    static constexpr float coding_and_noise = 24;

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

/// Where in an eye's picture the border of the window runs that its source is.
class WindowBorder {
public:
    WindowBorder(const SourceView& window, const EyeView& eye, const EyePicture& picture)
        : camera_(std::get<EquirectCamera>(window.camera)), lookup_(window.camera),
          rays_(eye.camera, eye.pose, window.pose), picture_(picture), eye_(eye),
          depth_m_(eye.depth_m.data != nullptr ? eye.depth_m
                   : !picture.depth_m.empty()  ? picture.depth_m.view()
                                               : ImageView<const float>{}) {}

    /// Of what is seen: the eye's, or what the engine found; empty where nobody knows it.
    ImageView<const float> depth_m() const { return depth_m_; }
    /// The window's share of a pixel's colour: 1 within, 0 on the border.
    float share(int x, int y) const {
        float inverse = 0;
        if (depth_m_.data != nullptr)
            inverse = radial_over_planar(eye_.camera, x, y) / depth_m_.pixel(x, y)[0];
        const PixelPosition p = lookup_.project(rays_.direction(x, y) + rays_.eye() * inverse);
        float inside = std::min(p.u, float(camera_.width) - p.u);
        // Over a pole there is nothing to mix with.
        if (camera_.range.latitude_max < pi / 2 - pole_rad)
            inside = std::min(inside, p.v);
        if (camera_.range.latitude_min > pole_rad - pi / 2)
            inside = std::min(inside, float(camera_.height) - p.v);
        return std::isnan(inside) ? 1 : std::clamp(inside / mixed_px, 0.0f, 1.0f);
    }

    /// Pixels that the window coloured, and not alone. Squares whose corners all lie well within it are passed over.
    Gaps pixels() const {
        std::vector<GapSpan> spans;
        const int width = picture_.origin.width(), height = picture_.origin.height();
        std::vector<bool> near(std::size_t(width / square_px + 1));
        for (int y = 0; y < height; ++y) {
            if (y % square_px == 0)
                for (int x = 0; x < width; x += square_px)
                    near[std::size_t(x / square_px)] = is_near(x, y);
            for (int x = 0; x < width; ++x)
                if (!near[std::size_t(x / square_px)])
                    x += square_px - 1 - x % square_px;
                else if (picture_.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::source) && share(x, y) < 1)
                    add(spans, x, y);
        }
        return Gaps(std::move(spans));
    }

private:
    /// Wide enough that the eye finds no line: a block of the window.
    static constexpr float mixed_px = window_block_px;
    static constexpr int square_px = 16;
    static constexpr double pole_rad = 1e-6;

    bool is_near(int x, int y) const {
        const int right = std::min(x + square_px, picture_.origin.width()) - 1;
        const int bottom = std::min(y + square_px, picture_.origin.height()) - 1;
        return share(x, y) < 1 || share(right, y) < 1 || share(x, bottom) < 1 || share(right, bottom) < 1;
    }
    static void add(std::vector<GapSpan>& spans, int x, int y) {
        if (!spans.empty() && spans.back().y == y && spans.back().end == x)
            ++spans.back().end;
        else
            spans.push_back({y, x, x + 1});
    }

    EquirectCamera camera_;
    SourceLookup lookup_;
    EyeRays rays_;
    const EyePicture& picture_;
    const EyeView& eye_;
    ImageView<const float> depth_m_;
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

/// The sphere around a window: what lies beyond the window's border, and a mixture of both along that border.
class BasePass : public PicturePass {
public:
    using PicturePass::PicturePass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    void mix_along_border(const WindowBorder& border, const EyeView& eye, EyePicture& picture) const;

    mutable ObjectPool<EyePicture> mixed_;
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

std::int64_t BasePass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (inputs_.base == nullptr || inputs_.main == nullptr)
        return 0;
    const std::int64_t filled = gaps.empty() ? 0 : fill_by_any(*inputs_.base, PixelOrigin::base, eye, picture, gaps);
    if (std::holds_alternative<EquirectCamera>(inputs_.main->camera))
        mix_along_border(WindowBorder(*inputs_.main, eye, picture), eye, picture);
    return filled;
}

void BasePass::mix_along_border(const WindowBorder& border, const EyeView& eye, EyePicture& picture) const {
    Gaps pixels = border.pixels();
    if (pixels.empty())
        return;
    const Gaps all = pixels;
    std::unique_ptr<EyePicture> from_base = mixed_.acquire();
    from_base->reset(eye.camera);
    const EyeView known{eye.camera, eye.pose, border.depth_m()};
    fill_by_any(*inputs_.base, PixelOrigin::base, known, *from_base, pixels);
    for (const GapSpan& span : all.spans())
        for (int x = span.begin; x < span.end; ++x) {
            if (from_base->origin.pixel(x, span.y)[0] == std::uint8_t(PixelOrigin::gap))
                continue;
            const float share = border.share(x, span.y);
            std::uint8_t* colour = picture.rgba.pixel(x, span.y);
            const std::uint8_t* other = from_base->rgba.pixel(x, span.y);
            for (int c = 0; c < 3; ++c)
                colour[c] = std::uint8_t(share * float(colour[c]) + (1 - share) * float(other[c]) + 0.5f);
        }
    mixed_.release(std::move(from_base));
}

}  // namespace

std::unique_ptr<FillPass> make_base_pass() {
    return std::make_unique<BasePass>("base");
}

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

}  // namespace equistream
