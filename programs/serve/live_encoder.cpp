#include "live_encoder.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

namespace equistream::serve {

namespace {

/// So long a viewer who comes waits at most, and one who lost something.
constexpr double longest_group_s = 1;
/// A group's range begins so much nearer than its first frame's nearest surface, as heads move on within it.
constexpr double room_to_approach = 0.8;
/// Slices in which a picture is coded side by side.
constexpr int encoder_threads = 2;

double nearest_in(const FloatImage& depth_m) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const float r : depth_m.samples())
        nearest_m = double(r) < nearest_m ? double(r) : nearest_m;
    return nearest_m;
}

}  // namespace

void LiveEncoder::open(const Frame& frame) {
    const FrameInfo& info = frame.info;
    StreamSettings settings;
    settings.crf = coding_.crf;
    settings.preset = coding_.preset;
    settings.frames_per_second = info.frames_per_second;
    settings.scene = info.scene;
    settings.threads = encoder_threads;
    settings.live = true;
    const auto* sphere = std::get_if<EquirectCamera>(&info.camera);
    settings.full_sphere = sphere != nullptr && sphere->range.is_full_sphere();
    settings.tracks.push_back({TrackRole::main, width_of(info.camera), height_of(info.camera)});
    box_radius_m_ = head_box_radius(info.eye, info.head_radius_m, info.ipd_m);
    if (coding_.depth && box_radius_m_ > 0) {
        depth_code_ = make_depth_code(DepthCodeId::w10);
        settings.tracks.push_back({TrackRole::depth, width_of(info.camera), height_of(info.camera), depth_code_->id()});
    }
    const auto take = [this](std::span<const std::uint8_t> bytes) { taken_.append(bytes.begin(), bytes.end()); };
    const std::string target = coding_.out.empty() ? "live.mkv" : coding_.out;
    writer_ = std::make_unique<StreamWriter>(target, settings, StreamTap{take, coding_.out.empty()});
}

DepthRange LiveEncoder::range_before(double nearest_m) const {
    return depth_range(*depth_code_, box_radius_m_, room_to_approach * nearest_m, default_focal_length_px);
}

bool LiveEncoder::needs_group(const FrameInfo& info, double nearest_m) const {
    if (!group_start_s_ || info.time_s - *group_start_s_ >= longest_group_s)
        return true;
    return depth_code_ && nearest_m < range_.near_m && range_before(nearest_m).near_m < range_.near_m;
}

LiveEncoder::Coded LiveEncoder::encode(const std::string& file, bool begin_group) {
    std::vector<std::string> planes = {"colour"};
    if (coding_.depth)
        planes.push_back("depth");
    const Frame frame = read_exr(file, planes);
    std::filesystem::remove(file);
    Coded coded;
    if (!writer_) {
        open(frame);
        coded.header = std::exchange(taken_, {});
    }
    const double nearest_m = depth_code_ ? nearest_in(frame.planes.at("depth")) : 0;
    coded.begins_group = begin_group || needs_group(frame.info, nearest_m);
    if (coded.begins_group) {
        group_start_s_ = frame.info.time_s;
        if (depth_code_)
            range_ = range_before(nearest_m);
        writer_->begin_group();
    }
    FrameInfo info = frame.info;
    const FloatImage display = display_.to_display(frame.planes.at("colour").view(), info.exposure);
    writer_->write(TrackRole::main, quantise_8bit(display.view()).view(), info);
    if (depth_code_) {
        info.depth_code = DepthCodeInfo{depth_code_->id(), range_, 0};
        writer_->write_depth(TrackRole::depth, frame.planes.at("depth").view(), info);
    }
    writer_->flush();
    coded.bytes = std::exchange(taken_, {});
    return coded;
}

std::string LiveEncoder::finish() {
    if (!writer_)
        return {};
    writer_->finish();
    return std::exchange(taken_, {});
}

}  // namespace equistream::serve
