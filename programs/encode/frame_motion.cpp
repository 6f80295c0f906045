#include "frame_motion.h"

#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>

namespace equistream {

namespace {

struct Neighbour {
    std::int64_t step;
    const char* plane;
};
constexpr Neighbour neighbours[] = {{-1, "backward"}, {1, "forward"}};

}  // namespace

std::vector<std::string> motion_planes(const std::filesystem::path& file) {
    const Frame frame = read_exr(file);
    std::vector<std::string> planes = {"depth", "backward", "forward"};
    for (const std::string& plane : planes)
        if (!frame.planes.contains(plane))
            throw InputError(expected_found(file.string(),
                                            "plane '" + plane + "' for --motion (render --aovs depth,motion)", "none"));
    if (frame.ids.contains("object_id"))
        planes.emplace_back("object_id");
    return planes;
}

FoundMotion find_motion(const std::filesystem::path& folder, const Frame& frame, std::int64_t index) {
    MotionPlanes planes{frame.info.camera, frame.info.camera_pose, frame.planes.at("depth").view(), {}, {}};
    if (const auto ids = frame.ids.find("object_id"); ids != frame.ids.end())
        planes.object_id = ids->second.view();
    for (const auto& [step, name] : neighbours) {
        const std::filesystem::path beside = folder / frame_file_name(index + step);
        if (index + step < 0 || !std::filesystem::exists(beside))
            continue;
        // Where there is no frame, motion was made with a camera that rests, or with one that nobody knows.
        const FrameInfo there = read_exr_info(beside);
        planes.neighbours.push_back(
            {there.camera_pose, there.time_s - frame.info.time_s, frame.planes.find(name)->second.view()});
    }
    return planes.neighbours.empty() ? FoundMotion{} : find_moving_regions(planes);
}

void MotionTotals::add(const FoundMotion& found, FrameInfo& info) {
    info.moving = found.regions;
    while (motion_bytes(info) > max_motion_bytes) {
        info.moving.pop_back();
        ++left_out;
    }
    if (info.moving.empty())
        return;
    ++frames;
    max_regions = std::max(max_regions, std::int64_t(info.moving.size()));
    bytes += std::int64_t(motion_bytes(info));
    const double pixels_per_rad = default_focal_length_px, count = double(found.moving_pixels);
    const auto blend = [&](double& mean, double value_rad) {
        mean = (mean * pixels_ + value_rad * pixels_per_rad * count) / (pixels_ + count);
    };
    blend(mean_motion_px, found.mean_motion_rad);
    blend(mean_error_px, found.mean_error_rad);
    pixels_ += count;
    worst_p95_error_px = std::max(worst_p95_error_px, found.p95_error_rad * pixels_per_rad);
}

}  // namespace equistream
