#include "fill.h"

#include <equistream/window.h>

#include <client/reflections/specular.h>
#include <client/warp/eye_rays.h>
#include <client/warp/resample.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <variant>

namespace equistream {

BaseEngine::BaseEngine(std::string_view engine, const EngineOptions& options) : engine_(make_engine(engine, options)) {}

void BaseEngine::set_base(const SourceView& base) {
    base_ = base;
    is_source_ = false;
}

void BaseEngine::reproject(const EyeView& eye, EyePicture& picture) const {
    if (base_.depth_m.data == nullptr && engine_->needs_depth(base_.pose, eye.pose).any()) {
        picture.size_for(eye.camera);
        resample_by_direction(base_, eye, {}, picture);
        return;
    }
    {
        const std::scoped_lock lock(mutex_);
        // While it waits for other threads it takes no work of the other eye, which waits for the lock.
        if (!is_source_)
            tbb::this_task_arena::isolate([&] { engine_->set_source(base_); });
        is_source_ = true;
    }
    engine_->reproject(eye, picture);
}

namespace {

/// Columns left to right - 1 of rows top to bottom - 1.
struct Square {
    int left, top, right, bottom;
};

ImageView<const float> depth_of(const EyeView& eye, const EyePicture& picture) {
    if (eye.depth_m.data != nullptr)
        return eye.depth_m;
    return picture.depth_m.empty() ? ImageView<const float>{} : picture.depth_m.view();
}

/// Where in an eye's picture the border of the window runs that its source is.
class WindowBorder {
public:
    WindowBorder(const SourceView& window, const EyeView& eye)
        : window_(window), camera_(std::get<EquirectCamera>(window.camera)), lookup_(window.camera),
          rays_(eye.camera, eye.pose, window.pose), eye_(eye) {}

    /// Where in the window a pixel's point lies, by depth of what is seen. Where nobody knows that, it is taken to be
    /// far away.
    PixelPosition position(ImageView<const float> depth_m, int x, int y) const {
        const float radial_m = depth_m.data != nullptr ? depth_m.pixel(x, y)[0] : std::nanf("");
        const float inverse = std::isnan(radial_m) ? 0 : radial_over_planar(eye_.camera, x, y) / radial_m;
        return lookup_.project(rays_.direction(x, y) + rays_.eye() * inverse);
    }
    /// Whether the window knows of a mirror there.
    bool has_mirror(PixelPosition p) const {
        const ImageView<const float>& mask = window_.specular;
        if (mask.data == nullptr || window_.depth_m.data == nullptr || !lookup_.contains(p))
            return false;
        const int x = std::clamp(int(p.u), 0, mask.width - 1), y = std::clamp(int(p.v), 0, mask.height - 1);
        return specular_sample(window_, x, y).specular;
    }
    /// The window's share of such a pixel's colour: 1 within, 0 on the border and beyond.
    float share(PixelPosition p) const {
        // Where columns close, and over a pole, there is nothing to mix with.
        const bool is_apart = camera_.range.closes() && !std::isnan(p.u);
        float inside = is_apart ? mixed_px : std::min(p.u, float(camera_.width) - p.u);
        if (camera_.range.latitude_max < pi / 2 - pole_rad)
            inside = std::min(inside, p.v);
        if (camera_.range.latitude_min > pole_rad - pi / 2)
            inside = std::min(inside, float(camera_.height) - p.v);
        return std::isnan(inside) ? 1 : std::clamp(inside / mixed_px, 0.0f, 1.0f);
    }

    /// All but those whose corners lie well within the window.
    std::vector<Square> squares(ImageView<const float> depth_m) const {
        std::vector<Square> squares;
        for (int top = 0; top < eye_.camera.height; top += square_px)
            for (int left = 0; left < eye_.camera.width; left += square_px) {
                const int right = std::min(left + square_px, eye_.camera.width);
                const int bottom = std::min(top + square_px, eye_.camera.height);
                const auto is_near = [&](int x, int y) { return share(position(depth_m, x, y)) < 1; };
                if (is_near(left, top) || is_near(right - 1, top) || is_near(left, bottom - 1) ||
                    is_near(right - 1, bottom - 1))
                    squares.push_back({left, top, right, bottom});
            }
        return squares;
    }

private:
    /// Wide enough that the eye finds no line: a block of the window.
    static constexpr float mixed_px = window_block_px;
    static constexpr int square_px = 16;
    static constexpr double pole_rad = 1e-6;

    const SourceView& window_;
    EquirectCamera camera_;
    SourceLookup lookup_;
    EyeRays rays_;
    const EyeView& eye_;
};

/// The sphere around a window: what lies beyond the window's border, and a mixture of both along that border.
class BasePass : public FillPass {
public:
    using FillPass::FillPass;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    void see(const EyeView& eye, EyePicture& from_base) const;

    mutable ObjectPool<EyePicture> pictures_;
};

void BasePass::see(const EyeView& eye, EyePicture& from_base) const {
    if (inputs_.base_engine != nullptr) {
        inputs_.base_engine->reproject(eye, from_base);
        return;
    }
    from_base.size_for(eye.camera);
    resample_by_direction(*inputs_.base, eye, {}, from_base);
}

bool has_colour(const EyePicture& picture, int x, int y) {
    return picture.origin.pixel(x, y)[0] != std::uint8_t(PixelOrigin::gap);
}

/// What mirrors of the window show is not on them: gaps there stay.
std::int64_t fill_from_base(const WindowBorder& border, const EyeView& eye, const EyePicture& from_base,
                            EyePicture& picture, const Gaps& gaps) {
    const ImageView<const float> depth_m = depth_of(eye, from_base);
    std::int64_t filled = 0;
    for (const GapSpan& span : gaps.spans())
        for (int x = span.begin; x < span.end; ++x) {
            if (!has_colour(from_base, x, span.y) || border.has_mirror(border.position(depth_m, x, span.y)))
                continue;
            std::copy_n(from_base.rgba.pixel(x, span.y), 4, picture.rgba.pixel(x, span.y));
            *picture.origin.pixel(x, span.y) = std::uint8_t(PixelOrigin::base);
            if (!picture.depth_m.empty())
                *picture.depth_m.pixel(x, span.y) =
                    from_base.depth_m.empty() ? std::nanf("") : *from_base.depth_m.pixel(x, span.y);
            ++filled;
        }
    return filled;
}

/// What the window coloured, and not alone.
void mix_along_border(const WindowBorder& border, const EyeView& eye, std::span<const Square> squares,
                      const EyePicture& from_base, EyePicture& picture) {
    const ImageView<const float> depth_m = depth_of(eye, picture);
    for (const Square& square : squares)
        for (int y = square.top; y < square.bottom; ++y)
            for (int x = square.left; x < square.right; ++x) {
                if (*picture.origin.pixel(x, y) != std::uint8_t(PixelOrigin::source) || !has_colour(from_base, x, y))
                    continue;
                const int share = int(border.share(border.position(depth_m, x, y)) * float(window_mix_steps) + 0.5f);
                std::uint8_t* colour = picture.rgba.pixel(x, y);
                const std::uint8_t* other = from_base.rgba.pixel(x, y);
                for (int c = 0; c < 3; ++c)
                    colour[c] = std::uint8_t(
                        (share * colour[c] + (window_mix_steps - share) * other[c] + window_mix_steps / 2) /
                        window_mix_steps);
            }
}

std::int64_t BasePass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (inputs_.base == nullptr || inputs_.main == nullptr ||
        !std::holds_alternative<EquirectCamera>(inputs_.main->camera))
        return 0;
    const WindowBorder border(*inputs_.main, eye);
    const std::vector<Square> squares = border.squares(depth_of(eye, picture));
    if (squares.empty())
        return 0;
    std::unique_ptr<EyePicture> from_base = pictures_.acquire();
    see(eye, *from_base);
    mix_along_border(border, eye, squares, *from_base, picture);
    const std::int64_t filled = fill_from_base(border, eye, *from_base, picture, gaps);
    gaps.narrow(picture.origin.view());
    pictures_.release(std::move(from_base));
    return filled;
}

}  // namespace

std::unique_ptr<FillPass> make_base_pass() {
    return std::make_unique<BasePass>("base", true);
}

}  // namespace equistream
