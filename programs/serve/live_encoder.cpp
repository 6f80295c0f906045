#include "live_encoder.h"

#include "rate.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/window.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

namespace equistream::serve {

namespace {

/// Viewers that come ask for groups, and key frames take bits from all.
constexpr double shortest_group_s = 0.25;
/// A group's range begins so much nearer than its first frame's nearest surface, as heads move on within it.
constexpr double room_to_approach = 0.8;
/// Depth is coded as asked for until colour has given up so many steps of CRF.
constexpr double colour_first = 12;
/// Slices in which a picture is coded side by side.
constexpr int encoder_threads = 2;

double nearest_in(const FloatImage& depth_m) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const float r : depth_m.samples())
        nearest_m = double(r) < nearest_m ? double(r) : nearest_m;
    return nearest_m;
}

}  // namespace

void LiveEncoder::read(Part& part, const std::string& file) const {
    std::vector<std::string> planes = {"colour"};
    if (coding_.depth)
        planes.push_back("depth");
    part.frame = read_exr(file, planes);
    std::filesystem::remove(file);
    if (coding_.depth)
        part.nearest_m = nearest_in(part.frame.planes.at("depth"));
}

void LiveEncoder::open() {
    const FrameInfo& info = parts_.front().frame.info;
    StreamSettings settings;
    settings.crf = coding_.crf;
    settings.preset = coding_.preset;
    settings.frames_per_second = info.frames_per_second;
    settings.scene = info.scene;
    settings.threads = encoder_threads;
    settings.live = true;
    const auto* sphere = std::get_if<EquirectCamera>(&info.camera);
    if (sphere != nullptr)
        settings.sphere = sphere->range;
    box_radius_m_ = head_box_radius(info.eye, info.head_radius_m, info.ipd_m);
    if (coding_.depth && box_radius_m_ > 0)
        depth_code_ = make_depth_code(coding_.depth_code);
    for (Part& part : parts_) {
        part.width = width_of(part.frame.info.camera);
        part.height = height_of(part.frame.info.camera);
        settings.tracks.push_back({part.role, part.width, part.height});
        if (depth_code_)
            settings.tracks.push_back({*depth_role_of(part.role), part.width, part.height, depth_code_->id()});
    }
    window_pixels_ = double(parts_.back().width) * parts_.back().height;
    if (parts_.size() > 1)
        parts_.front().focal_length_px =
            base_focal_length_px(parts_.front().frame.info.camera, parts_.back().frame.info.camera);
    const auto take = [this](std::span<const std::uint8_t> bytes) { taken_.append(bytes.begin(), bytes.end()); };
    const std::string target = coding_.out.empty() ? "live.mkv" : coding_.out;
    writer_ = std::make_unique<StreamWriter>(target, settings, StreamTap{take, coding_.out.empty()});
}

DepthRange LiveEncoder::range_before(const Part& part) const {
    return depth_range(*depth_code_, box_radius_m_, room_to_approach * part.nearest_m, false, part.focal_length_px);
}

bool LiveEncoder::has_size_of_track(const Part& part) const {
    return width_of(part.frame.info.camera) == part.width && height_of(part.frame.info.camera) == part.height;
}

double LiveEncoder::window_halvings() const {
    const Camera& camera = parts_.back().frame.info.camera;
    return std::log2(window_pixels_ / (double(width_of(camera)) * height_of(camera)));
}

void LiveEncoder::follow_size(Part& part) {
    if (has_size_of_track(part))
        return;
    part.width = width_of(part.frame.info.camera);
    part.height = height_of(part.frame.info.camera);
    writer_->set_size(part.role, part.width, part.height);
    if (depth_code_)
        writer_->set_size(*depth_role_of(part.role), part.width, part.height);
}

bool LiveEncoder::needs_group() const {
    if (!std::ranges::all_of(parts_, [&](const Part& part) { return has_size_of_track(part); }))
        return true;
    if (!group_start_s_ || parts_.front().frame.info.time_s - *group_start_s_ >= coding_.longest_group_s)
        return true;
    return depth_code_ && std::ranges::any_of(parts_, [&](const Part& part) {
               return part.nearest_m < part.range.near_m && range_before(part).near_m < part.range.near_m;
           });
}

void LiveEncoder::write(const Part& part) {
    FrameInfo info = part.frame.info;
    const FloatImage display = display_.to_display(part.frame.planes.at("colour").view(), info.exposure);
    writer_->write(part.role, quantise_8bit(display.view()).view(), info);
    if (!depth_code_)
        return;
    info.depth_code = DepthCodeInfo{depth_code_->id(), part.range, 0};
    writer_->write_depth(*depth_role_of(part.role), part.frame.planes.at("depth").view(), info);
}

/// A part's depth gives way so much after its colour, and a window's CRF after its pixels.
void LiveEncoder::set_quality(double coarser) {
    const std::pair quality(coarser, window_halvings());
    if (std::exchange(quality_, quality) == quality)
        return;
    const CoarserParts parts = divided(coarser, parts_.size() > 1);
    for (const Part& part : parts_) {
        const double steps = part.role == TrackRole::window
                                 ? std::max(0.0, parts.window - steps_that_halve * quality.second)
                                 : parts.base;
        writer_->set_crf(part.role, std::min(coding_.crf + steps, double(worst_crf)));
        if (depth_code_)
            writer_->set_crf(*depth_role_of(part.role),
                             std::min(coding_.crf + std::max(0.0, steps - colour_first), double(worst_crf)));
    }
}

LiveEncoder::Coded LiveEncoder::encode(const std::string& file, const std::string& window, bool begin_group,
                                       double coarser, double now_s) {
    if (parts_.empty()) {
        parts_.push_back({TrackRole::main});
        if (!window.empty())
            parts_.push_back({TrackRole::window});
    }
    read(parts_.front(), file);
    if (parts_.size() > 1)
        read(parts_.back(), window);
    Coded coded;
    if (!writer_) {
        open();
        coded.header = std::exchange(taken_, {});
    }
    coded.window_halvings = window_halvings();
    const double by_pixels = steps_that_halve * coded.window_halvings;
    coded.coarser = std::clamp(coarser, by_pixels, double(worst_crf) - coding_.crf + by_pixels);
    set_quality(coded.coarser);
    is_group_wanted_ = is_group_wanted_ || begin_group;
    coded.begins_group = needs_group() || (is_group_wanted_ && now_s - group_began_s_ >= shortest_group_s);
    if (coded.begins_group) {
        is_group_wanted_ = false;
        group_began_s_ = now_s;
        group_start_s_ = parts_.front().frame.info.time_s;
        if (depth_code_)
            for (Part& part : parts_)
                part.range = range_before(part);
        writer_->begin_group();
        for (Part& part : parts_)
            follow_size(part);
    }
    for (const Part& part : parts_)
        write(part);
    writer_->flush();
    coded.bytes = std::exchange(taken_, {});
    return coded;
}

std::string LiveEncoder::finish() {
    if (!writer_)
        return {};
    writer_->begin_group();  // whoever has left something out gets the end too
    writer_->finish();
    return std::exchange(taken_, {});
}

}  // namespace equistream::serve
