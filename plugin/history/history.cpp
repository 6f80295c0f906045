#include "history.h"

#include <plugin/export/parallel.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace equistream {
namespace {

/// Of a half float, as files hold it. Sums of its square still tell other pixels' variance apart.
constexpr float brightest = 65504;
/// Frames that the quick mean is over, at most.
constexpr float recent_frames = 4;
/// Pixels around one, in which a change of light is looked for.
constexpr int radii[] = {3, 10, 31};
/// Squared standard errors that noise alone never reaches.
constexpr float noise2 = 16;
/// Of the level: differences below it are none.
constexpr float min_change = 0.001f;
/// Pixels over which a denoiser or an eye takes means: bias weighs so much more than noise.
constexpr float pixels_seen_together = 100;
/// Pixels around one in which lost detail is looked for.
constexpr int detail_radius = 5;
/// Standard errors of it that noise alone may reach, and how much of the noise it may be at most.
constexpr double detail_sure = 1.5, max_lost = 1000;
/// Times what shows as white: larger innovations count as so much. Sums of their fourth power still tell other pixels
/// apart.
constexpr double max_innovation = 16;
/// Of the level: lost detail below it is not seen.
constexpr float min_detail = 0.01f;
/// Pixels around one over which denoised and accumulated light are told apart, and how surely: noise alone gives none
/// of the latter a share.
constexpr int share_radius = 4;
constexpr double share_noise = 1.5;

float brightness(const glm::vec4& colour) {
    return luminance(glm::vec3(colour));
}

/// Independent samples that the mean of `a`, weighed `weight_a`, and `b` is worth.
float worth(float a, float weight_a, float b, float weight_b) {
    return 1 / (weight_a * weight_a / a + weight_b * weight_b / b);
}

/// Whether pixels of both look the same ways. A window that has moved has other pixels.
bool has_same_pixels(const Camera& a, const Camera& b) {
    if (a.index() != b.index() || width_of(a) != width_of(b) || height_of(a) != height_of(b))
        return false;
    if (const auto* flat = std::get_if<PerspectiveCamera>(&a))
        return flat->fov_x_rad == std::get<PerspectiveCamera>(b).fov_x_rad;
    const auto &one = std::get<EquirectCamera>(a), &other = std::get<EquirectCamera>(b);
    const LongitudeLatitudeRange &r = one.range, &s = other.range;
    return one.ods_side_m == other.ods_side_m && r.longitude_min == s.longitude_min &&
           r.longitude_max == s.longitude_max && r.latitude_min == s.latitude_min && r.latitude_max == s.latitude_max;
}

}  // namespace

void History::resize(const FrameInfo& info) {
    camera_ = info.camera;
    width_ = width_of(camera_);
    height_ = height_of(camera_);
    closes_ = columns_close(camera_);
    const auto* sphere = std::get_if<EquirectCamera>(&camera_);
    constexpr double close = 1e-9;
    north_pole_ = closes_ && sphere->range.latitude_max >= pi / 2 - close;
    south_pole_ = closes_ && sphere->range.latitude_min <= -pi / 2 + close;
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    for (auto& means : means_)
        means.resize(pixels);
    for (auto& seen : seen_)
        seen.resize(pixels);
    changes_.resize(pixels);
    row_sums_.resize(pixels);
    bias2_.resize(pixels);
    lost_.resize(pixels);
    shares_.resize(pixels);
}

History::Planes::Planes(const Frame& frame)
    : colour(frame.planes.at("colour").samples().data()), backward(frame.planes.at("backward").samples().data()),
      virtual_backward(frame.planes.at("virtual_backward").samples().data()),
      samples_a_pixel(static_cast<float>(frame.info.samples_per_pixel)) {
    if (const auto found = frame.planes.find("raw"); found != frame.planes.end())
        raw = found->second.samples().data();
    if (const auto found = frame.planes.find("samples"); found != frame.planes.end()) {
        samples = found->second.samples().data();
        variance = frame.planes.at("variance").samples().data();
    }
}

History::Fresh History::fresh(const Planes& planes, std::size_t pixel) {
    Fresh f;
    const float* rgba = planes.colour + 4 * pixel;
    const float* rgb = planes.raw == nullptr ? rgba : planes.raw + 3 * pixel;
    const auto is_finite = [](float v) { return std::isfinite(v); };
    if (!std::all_of(rgb, rgb + 3, is_finite) || !std::all_of(rgba, rgba + 4, is_finite))
        return f;
    f.colour = glm::clamp(glm::vec4(rgb[0], rgb[1], rgb[2], rgba[3]), -brightest, brightest);
    f.denoised = glm::clamp(glm::vec3(rgba[0], rgba[1], rgba[2]), -brightest, brightest);
    f.level = brightness(f.colour);
    f.count = planes.samples == nullptr ? planes.samples_a_pixel : planes.samples[pixel];
    if (planes.samples != nullptr && f.count > 1) {
        f.freedom = f.count - 1;
        f.variance = std::min(planes.variance[pixel] * f.count, brightest * brightest);
    }
    return f;
}

/// How the quick mean, this frame included, differs from the mean before it, and by how much noise lets it.
History::Change History::change(const Mean& carried, const Fresh& fresh) const {
    if (carried.count <= 0 || fresh.count <= 0)
        return {};
    const float kept = std::min(carried.recent_count, recent_frames * fresh.count);
    const float weight = fresh.count / (kept + fresh.count);
    const float level = brightness(carried.colour);
    const float off = fresh.level - level;
    const float from_frame =
        fresh.freedom >= 1 ? fresh.variance : off * off * fresh.count * kept / (kept + fresh.count);
    return {carried.recent + weight * (fresh.level - carried.recent) - level,
            std::max(carried.variance, from_frame) / worth(carried.recent_count, 1 - weight, fresh.count, weight),
            level, 1};
}

/// Sums of `changes_` over squares of 2 radius + 1 pixels: use(pixel, sum) where there are any.
template <typename Use>
void History::sum_around(int radius, const Use& use) {
    struct Sum {
        double difference = 0, variance = 0, level = 0, count = 0;
        void add(const Change& c, double sign) {
            difference += sign * double(c.difference);
            variance += sign * double(c.variance);
            level += sign * double(c.level);
            count += sign * double(c.count);
        }
    };
    const int across = std::min(radius, (width_ - 1) / 2);
    for_each_row(height_, [&](int y) {
        Sum sum;
        const auto add = [&](int x, double sign) {
            if (const int column = closes_ ? (x + width_) % width_ : x; column >= 0 && column < width_)
                sum.add(changes_[index(column, y)], sign);
        };
        for (int x = -across; x < across; ++x)
            add(x, 1);
        for (int x = 0; x < width_; ++x) {
            add(x + across, 1);
            row_sums_[index(x, y)] = {static_cast<float>(sum.difference), static_cast<float>(sum.variance),
                                      static_cast<float>(sum.level), static_cast<float>(sum.count)};
            add(x - across, -1);
        }
    });
    for_each_row(width_, [&](int x) {
        Sum sum;
        const auto add = [&](int y, double sign) {
            if (y >= 0 && y < height_)
                sum.add(row_sums_[index(x, y)], sign);
        };
        for (int y = 0; y < radius; ++y)
            add(y, 1);
        for (int y = 0; y < height_; ++y) {
            add(y + radius, 1);
            if (sum.count > 0.5)
                use(index(x, y), sum);
            add(y - radius, -1);
        }
    });
}

void History::find_changes() {
    for (const int radius : radii)
        sum_around(radius, [&](std::size_t pixel, const auto& sum) {
            const double floor = double(min_change) * sum.level / sum.count;
            const double difference = sum.difference / sum.count;
            const double noise = double(noise2) * std::max(sum.variance, 0.0) / (sum.count * sum.count);
            bias2_[pixel] =
                std::max(bias2_[pixel], static_cast<float>(difference * difference - noise - floor * floor));
        });
}

/// Also takes down the innovations, for the next frame.
void History::find_lost_detail(const Planes& planes) {
    const float most = static_cast<float>(max_innovation / exposure_);
    for_each_row(height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const std::size_t i = index(x, y);
            const Fresh f = fresh(planes, i);
            Mean& m = means_[0][i];
            const bool is_known = f.count > 0 && m.count > 0;
            const float now = is_known ? std::clamp(f.level - brightness(m.colour), -most, most) : 0;
            const float before = std::exchange(m.innovation, now);
            const float again = now * before, unseen = min_detail * std::min(f.level, most);
            // Not where it stayed in its pixel, nor where the frame before had nothing to be compared with.
            changes_[i] = is_known && before != 0 && !m.stayed
                              ? Change{again - unseen * unseen, again * again, now * now, 1}
                              : Change{};
        }
    });
    sum_around(detail_radius, [&](std::size_t pixel, const auto& sum) {
        const double lost2 = sum.difference - detail_sure * std::sqrt(std::max(sum.variance, 0.0));
        const double of_noise = std::max(sum.level - sum.difference, lost2 / max_lost);
        lost_[pixel] = lost2 > 0 ? static_cast<float>(lost2 / of_noise) : 0;
    });
}

/// By how much the two differ beyond the mean's own noise, where nothing moves. There alone is that noise known: it is
/// fresh in every pixel.
void History::find_shares() {
    for (std::size_t i = 0; i < changes_.size(); ++i) {
        const Mean& m = means_[0][i];
        const float off = brightness(m.colour) - luminance(m.denoised);
        changes_[i] = m.count > 0 && m.stayed ? Change{off * off, m.variance / m.count, 0, 1} : Change{};
    }
    std::ranges::fill(shares_, 0.0f);
    sum_around(share_radius, [&](std::size_t pixel, const auto& sum) {
        if (changes_[pixel].count > 0 && sum.difference > share_noise * sum.variance)
            shares_[pixel] = static_cast<float>(1 - share_noise * std::max(sum.variance, 0.0) / sum.difference);
    });
}

/// Both means: which of them lags is not known. An eye sees many pixels together: their noise is less, their bias is
/// not.
void History::forget_changed(Mean& carried, float bias2) {
    if (!(bias2 > 0) || carried.count <= 0)
        return;
    const float noise = carried.variance / pixels_seen_together;
    const auto kept = [&](float count) {
        const float all = noise + count * bias2;
        return all > 0 ? noise / all : 1;
    };
    carried.freedom *= kept(carried.count);
    carried.recent_count *= kept(carried.recent_count);
    carried.count *= kept(carried.count);
}

void History::forget_lost(Mean& carried, float lost, float fresh_count) {
    if (carried.count <= 0 || fresh_count <= 0)
        return;
    const auto kept = [&](float count) { return 1 / (1 + lost * (1 + count / fresh_count)); };
    carried.freedom *= kept(carried.count);
    carried.recent_count *= kept(carried.recent_count);
    carried.count *= kept(carried.count);
}

void History::mix(Mean& carried, const Fresh& fresh) const {
    Mean& m = carried;
    const float n = fresh.count;
    if (n <= 0)
        return;
    if (m.count <= 0 || m.recent_count <= 0) {
        m = {fresh.colour, fresh.denoised, n, fresh.variance, fresh.freedom, fresh.level, n, 0, m.most, m.stayed};
        return;
    }
    const float kept = std::min(m.count, m.most * n);
    const float weight = n / (kept + n);
    const float off = fresh.level - brightness(m.colour);
    const float freedom = std::min(m.freedom, m.most * n);
    m.variance = (freedom * m.variance + fresh.freedom * fresh.variance + off * off * kept * weight) /
                 (freedom + fresh.freedom + 1);
    m.freedom = freedom + fresh.freedom + 1;
    m.colour += weight * (fresh.colour - m.colour);
    m.denoised += weight * (fresh.denoised - m.denoised);
    m.count = worth(m.count, 1 - weight, n, weight);
    const float recent_weight = n / (std::min(m.recent_count, recent_frames * n) + n);
    m.recent += recent_weight * (fresh.level - m.recent);
    m.recent_count = worth(m.recent_count, 1 - recent_weight, n, recent_weight);
}

void History::write(Frame& frame) const {
    FloatImage& colour = frame.planes.at("colour");
    const auto raw = frame.planes.find("raw");
    for (const char* name : {"samples", "variance"})
        if (FloatImage& plane = frame.planes[name]; plane.empty())
            plane = FloatImage(width_, height_, 1);
    FloatImage &samples = frame.planes.at("samples"), &variance = frame.planes.at("variance");
    for_each_row(height_, [&](int y) {
        const Mean* m = &means_[0][index(0, y)];
        for (int x = 0; x < width_; ++x, ++m) {
            const float share = raw == frame.planes.end() ? 1 : shares_[index(x, y)];
            for (int c = 0; c < 3; ++c) {
                if (raw != frame.planes.end())
                    raw->second.pixel(x, y)[c] = std::max(m->colour[c], 0.0f);
                if (raw == frame.planes.end() || m->count > 0)  // else as the denoiser fills it
                    colour.pixel(x, y)[c] = std::max(glm::mix(m->denoised[c], m->colour[c], share), 0.0f);
            }
            colour.pixel(x, y)[3] = std::max(m->colour[3], 0.0f);
            const float level = brightness(m->colour);
            *samples.pixel(x, y) = m->count;
            *variance.pixel(x, y) = m->count > 0 ? std::min((m->freedom > 0 ? m->variance : level * level) / m->count,
                                                            std::numeric_limits<float>::max())
                                                 : 0;
        }
    });
}

void History::accumulate(Frame& frame, const Before& before) {
    const FrameInfo& info = frame.info;
    assert(!info.patches);
    const bool goes_on = last_ && last_->index == before.index && has_same_pixels(camera_, info.camera) &&
                         last_->camera_pose.position_m == before.camera_pose.position_m &&
                         last_->camera_pose.orientation == before.camera_pose.orientation;
    before_last_ = goes_on ? last_ : std::nullopt;
    last_.reset();  // until all is done
    resize(info);
    std::swap(means_[0], means_[1]);
    std::swap(seen_[0], seen_[1]);
    see(frame);
    const Planes planes(frame);
    find_rims(planes);
    const Poses poses{before.camera_pose, info.camera_pose};
    exposure_ = info.exposure;
    for_each_row(height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const std::size_t i = index(x, y);
            means_[0][i] = goes_on ? carried(planes, x, y, poses) : Mean{};
            changes_[i] = change(means_[0][i], fresh(planes, i));
        }
    });
    std::ranges::fill(bias2_, 0.0f);
    std::ranges::fill(lost_, 0.0f);
    if (goes_on) {
        find_changes();
        find_lost_detail(planes);
    }
    for_each_row(height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const std::size_t i = index(x, y);
            Mean& mean = means_[0][i];
            const Fresh f = fresh(planes, i);
            forget_changed(mean, bias2_[i]);
            forget_lost(mean, lost_[i], f.count);
            mix(mean, f);
        }
    });
    if (planes.raw != nullptr)
        find_shares();
    write(frame);
    last_ = Before{info.index, info.camera_pose};
}

void History::take_back() {
    std::swap(means_[0], means_[1]);
    std::swap(seen_[0], seen_[1]);
    last_ = std::exchange(before_last_, std::nullopt);
}

std::vector<std::uint32_t> History::samples_by_tile(const FrameInfo& next, int tile_side) const {
    const std::uint32_t mean = next.samples_per_pixel;
    if (!last_ || mean < 2 || !has_same_pixels(camera_, next.camera))
        return {};
    const int across = (width_ + tile_side - 1) / tile_side, down = (height_ + tile_side - 1) / tile_side;
    std::vector<double> doubt, pixels;
    for (int tile = 0; tile < across * down; ++tile) {
        const int left = tile % across * tile_side, top = tile / across * tile_side;
        const int right = std::min(left + tile_side, width_), bottom = std::min(top + tile_side, height_);
        double sum = 0;
        for (int y = top; y < bottom; ++y)
            for (int x = left; x < right; ++x) {
                const Mean& m = means_[0][index(x, y)];
                // As it shows after a display transform, which is about logarithmic.
                constexpr double dark = 0.05;
                const double shown = exposure_ / (std::max(exposure_ * double(brightness(m.colour)), 0.0) + dark);
                sum += m.count > 0 ? double(m.variance) / double(m.count) * shown * shown : 1;
            }
        pixels.push_back(double(right - left) * (bottom - top));
        doubt.push_back(std::sqrt(sum / pixels.back()));
    }
    const double least = std::max(1.0, mean / 2.0), most = 4.0 * mean;
    const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0) * mean;
    const auto given = [&](double scale, std::size_t tile) { return std::clamp(scale * doubt[tile], least, most); };
    // The scale at which all are given: their sum grows with it, so bisection finds it.
    double low = 0, high = most / std::max(1e-12, *std::ranges::min_element(doubt));
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        double sum = 0;
        for (std::size_t tile = 0; tile < doubt.size(); ++tile)
            sum += given(middle, tile) * pixels[tile];
        (sum > all ? high : low) = middle;
    }
    std::vector<std::uint32_t> counts;
    double owed = 0;
    for (std::size_t tile = 0; tile < doubt.size(); ++tile) {
        const double exact = given(low, tile) * pixels[tile] + owed;
        counts.push_back(static_cast<std::uint32_t>(std::clamp(std::round(exact / pixels[tile]), 1.0, most)));
        owed = exact - counts.back() * pixels[tile];
    }
    return counts;
}

}  // namespace equistream
