#include "background_depth.h"

#include <cmath>
#include <limits>

namespace equistream {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// The farther of two ends, of which either may be unknown.
float farther(float a, float b) {
    return std::fmax(a, b);
}

class Background {
public:
    Background(const EyeView& eye, const EyePicture& picture, const glm::dvec3& epipole, FloatImage& out)
        : eye_(eye), picture_(picture), epipole_(epipole), out_(out) {}

    void run(std::span<const GapSpan> spans) {
        // First the nearest end above, then, from the bottom up, the one below and the row's own.
        for (const GapSpan& span : spans)
            for (int x = span.begin; x < span.end; ++x)
                out_.pixel(x, span.y)[0] = above(x, span.y);
        below_.assign(std::size_t(out_.width()), unknown);
        for (auto span = spans.rbegin(); span != spans.rend(); ++span) {
            const int row = span->y;
            const float left = span->begin > 0 ? picture_.depth_m.pixel(span->begin - 1, row)[0] : unknown;
            const float right = span->end < out_.width() ? picture_.depth_m.pixel(span->end, row)[0] : unknown;
            for (int x = span->begin; x < span->end; ++x) {
                if (!open(x, row + 1))
                    below_[std::size_t(x)] = row + 1 < out_.height() ? picture_.depth_m.pixel(x, row + 1)[0] : unknown;
                settle(x, row, farther(left, right), below_[std::size_t(x)]);
            }
        }
    }

private:
    bool open(int x, int y) const {
        return y >= 0 && y < out_.height() && picture_.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::gap);
    }

    /// The depth of the run's end above, taken over from the gap pixel there.
    float above(int x, int y) const {
        if (y == 0)
            return unknown;
        return open(x, y - 1) ? out_.pixel(x, y - 1)[0] : picture_.depth_m.pixel(x, y - 1)[0];
    }

    void settle(int x, int y, float in_row, float below) {
        float& depth = out_.pixel(x, y)[0];
        const float in_column = farther(depth, below);
        // The epipolar line's direction here, up to scale: the derivative of the pixel as the eye moves.
        const double a = x + 0.5 - 0.5 * eye_.camera.width, b = y + 0.5 - 0.5 * eye_.camera.height;
        const double f = eye_.camera.focal_px();
        const double along_x = std::abs(f * epipole_.x + a * epipole_.z);
        const double along_y = std::abs(-f * epipole_.y + b * epipole_.z);
        if (along_x == along_y)
            depth = farther(in_row, in_column);
        else if (along_x > along_y)
            depth = std::isnan(in_row) ? in_column : in_row;
        else
            depth = std::isnan(in_column) ? in_row : in_column;
    }

    const EyeView& eye_;
    const EyePicture& picture_;
    glm::dvec3 epipole_;
    FloatImage& out_;
    std::vector<float> below_;
};

}  // namespace

void find_background(const EyeView& eye, const EyePicture& picture, const Gaps& gaps, const glm::dvec3& epipole,
                     FloatImage& background_m) {
    if (background_m.width() != picture.origin.width() || background_m.height() != picture.origin.height())
        background_m = FloatImage(picture.origin.width(), picture.origin.height(), 1);
    Background(eye, picture, epipole, background_m).run(gaps.spans());
}

}  // namespace equistream
