#include "describe.h"

#include <plugin/export/frame_json.h>

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <programs/cli/provenance.h>

#include <algorithm>

namespace equistream {

namespace {

constexpr double degrees = 180 / pi;

double head_box_radius_m(const FrameInfo& info) {
    return head_box_radius(info.eye, info.head_radius_m, info.ipd_m);
}

std::string camera_text(const Camera& camera) {
    const std::string size = formatted("%dx%d", width_of(camera), height_of(camera));
    if (const auto* perspective = std::get_if<PerspectiveCamera>(&camera))
        return size + formatted(" perspective, %.1f degrees wide", perspective->fov_x_rad * degrees);
    const auto& range = std::get<EquirectCamera>(camera).range;
    return size + formatted(" %s, longitude %.1f to %.1f, latitude %.1f to %.1f degrees",
                            is_ods(camera) ? "omnidirectional stereo" : "equirect", range.longitude_min * degrees,
                            range.longitude_max * degrees, range.latitude_min * degrees, range.latitude_max * degrees);
}

nlohmann::json depth_code_json(const FrameInfo& info) {
    if (!info.depth_code)
        return nullptr;
    const DepthRange& range = info.depth_code->range;
    return {{"code", depth_code_name(info.depth_code->code)},
            {"scale", info.depth_code->halved ? 2 : 1},
            {"box_radius_m", range.box_radius_m},
            {"near_m", range.near_m},
            {"has_empty", range.has_empty},
            {"clamped_pixels", info.depth_code->clamped_pixels}};
}

std::string depth_code_text(const DepthCodeInfo& depth_code) {
    std::string text = "  depth      coded as " + std::string(depth_code_name(depth_code.code));
    if (depth_code.halved)
        text += " at half the columns and rows";
    if (depth_code.code == DepthCodeId::lossless)
        return text + ", exactly\n";
    text +=
        formatted(" from %.3f m on, for eyes within %.4f m", depth_code.range.near_m, depth_code.range.box_radius_m);
    if (depth_code.range.has_empty)
        text += "; pixels may hold no surface";
    if (depth_code.clamped_pixels > 0)
        text += formatted("; %u pixels lay nearer", depth_code.clamped_pixels);
    return text + "\n";
}

nlohmann::json moving_json(const std::vector<MovingRegion>& regions) {
    const auto vector = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    const auto twist = [&](const Twist& t) {
        return nlohmann::json{{"velocity_m_s", vector(t.velocity_m_s)}, {"angular_rad_s", vector(t.angular_rad_s)}};
    };
    nlohmann::json json = nlohmann::json::array();
    for (const MovingRegion& region : regions)
        json.push_back({{"twist", twist(region.motion.twist)},
                        {"twist_per_second", twist(region.motion.twist_per_second)},
                        {"near_m", region.near_m},
                        {"far_m", region.far_m},
                        {"pixels", region.pixels()}});
    return json;
}

/// Of VisibleLoss::textures, as an example of much.
constexpr std::size_t textured = 4;

std::string visible_loss_text(const FrameInfo& info) {
    if (!info.visible_loss)
        return "";
    const auto percent = [&](float texture) { return 100 * double(loss_at(*info.visible_loss, texture)); };
    return formatted("  visible    %.2g %% of flat pixels are visibly off, %.2g %% of textured ones\n",
                     percent(VisibleLoss::textures.front()), percent(VisibleLoss::textures[textured]));
}

/// Frames of other renderers are imported without samples and seed.
std::string renderer_text(const FrameInfo& info) {
    const std::string host = info.host.empty() ? "an unnamed host" : shown(info.host);
    if (info.samples_per_pixel == 0)
        return host + "; samples and seed not known";
    return formatted("%u samples a pixel, seed %llu, by ", info.samples_per_pixel,
                     static_cast<unsigned long long>(info.seed)) +
           host;
}

}  // namespace

std::string shown(const std::string& text) {
    constexpr std::size_t longest_bytes = 1 << 16;  // of a command line that a manifest records
    return quotable(text, longest_bytes);
}

std::string bytes_text(double bytes) {
    if (bytes < 1000)
        return formatted("%.0f bytes", bytes);
    return bytes < 1e6 ? formatted("%.1f kB", bytes / 1e3) : formatted("%.2f MB", bytes / 1e6);
}

std::string pose_text(const Pose& pose) {
    const auto& p = pose.position_m;
    const auto& q = pose.orientation;
    return formatted("at (%.4f, %.4f, %.4f) m, turned (w %.5f, x %.5f, y %.5f, z %.5f)", p.x, p.y, p.z, q.w, q.x, q.y,
                     q.z);
}

nlohmann::json frame_json(const FrameInfo& info) {
    return {{"index", info.index},
            {"time_s", info.time_s},
            {"frames_per_second", info.frames_per_second},
            {"camera", camera_to_json(info.camera)},
            {"window_columns", info.window_columns > 0 ? nlohmann::json(info.window_columns) : nlohmann::json()},
            {"camera_pose", pose_to_json(info.camera_pose)},
            {"head", pose_to_json(info.head)},
            {"eye", eye_names[static_cast<int>(info.eye)]},
            {"ipd_m", info.ipd_m},
            {"lock", axis_lock_names[static_cast<int>(info.lock)]},
            {"packing", packing_names[static_cast<int>(info.packing)]},
            {"lean_m", info.head_radius_m},
            {"head_box_radius_m", head_box_radius_m(info)},
            {"exposure", info.exposure},
            {"seed", info.seed},
            {"samples_per_pixel", info.samples_per_pixel},
            {"scene", info.scene},
            {"host", info.host},
            {"geometry_fingerprint", info.geometry_fingerprint},
            {"denoiser", info.denoiser.empty() ? nlohmann::json() : nlohmann::json(info.denoiser)},
            {"depth_code", depth_code_json(info)},
            {"crf", cli::or_null(info.crf)},
            {"visible_loss", info.visible_loss ? visible_loss_to_json(*info.visible_loss) : nlohmann::json()},
            {"moving", moving_json(info.moving)}};
}

std::string shared_text(const FrameInfo& info) {
    std::string text = "  scene      " + (info.scene.empty() ? std::string("not known") : shown(info.scene));
    text += formatted(", exposure %g\n", info.exposure);
    if (!info.geometry_fingerprint.empty())
        text += "  geometry   fingerprint " + shown(info.geometry_fingerprint) + "\n";
    text += "  rendered   " + renderer_text(info) + "\n";
    if (!info.denoiser.empty())
        text += "  denoised   by " + shown(info.denoiser) + "\n";
    if (info.crf)
        text += formatted("  coded      at CRF %g\n", double(*info.crf));
    text += visible_loss_text(info);
    if (info.depth_code)
        text += depth_code_text(*info.depth_code);
    if (info.window_columns == 0)
        text += "  camera     " + camera_text(info.camera) + "\n";
    else  // where it is differs from frame to frame
        text += formatted("  camera     window %dx%d of a sphere of %d columns\n", width_of(info.camera),
                          height_of(info.camera), info.window_columns);
    const std::string packing = packing_names[static_cast<int>(info.packing)];
    text += formatted("  eye        %s, %.1f mm between the eyes",
                      info.packing != StereoPacking::none ? ("both in each picture, " + packing).c_str()
                                                          : eye_names[static_cast<int>(info.eye)],
                      info.ipd_m * 1e3);
    if (std::holds_alternative<EquirectCamera>(info.camera))  // a perspective one turns with the head
        text += formatted("; axes locked to the %s", axis_lock_names[static_cast<int>(info.lock)]);
    text += "\n";
    text += formatted("  head box   the head may lean %g m: both eyes stay within %.4f m of the camera\n",
                      info.head_radius_m, head_box_radius_m(info));
    return text;
}

void FrameRun::add(const FrameInfo& frame) {
    const glm::dvec3& position_m = frame.camera_pose.position_m;
    if (count++ == 0) {
        first = frame;
        low = high = position_m;
    }
    last_index = frame.index;
    last_time_s = frame.time_s;
    low = glm::min(low, position_m);
    high = glm::max(high, position_m);
}

std::string range_text(const FrameRun& frames) {
    if (frames.count == 0)
        return "";
    const glm::dvec3 &low = frames.low, &high = frames.high;
    return formatted("  time       %.3f to %.3f s\n  positions  x %.3f to %.3f, y %.3f to %.3f, z %.3f to %.3f m\n",
                     frames.first.time_s, frames.last_time_s, low.x, high.x, low.y, high.y, low.z, high.z);
}

nlohmann::json range_json(const FrameRun& frames) {
    if (frames.count == 0)
        return nullptr;
    const glm::dvec3 &low = frames.low, &high = frames.high;
    return {{"first", frames.first.index},
            {"last", frames.last_index},
            {"time_s", {frames.first.time_s, frames.last_time_s}},
            {"position_low_m", {low.x, low.y, low.z}},
            {"position_high_m", {high.x, high.y, high.z}}};
}

void list_frame(const FrameInfo& frame, const DescribeOptions& options, Description& list) {
    if (options.json)
        list.json.push_back(frame_json(frame));
    else
        list.text += formatted("  frame %-5lld %.4f s  ", static_cast<long long>(frame.index), frame.time_s) +
                     pose_text(frame.camera_pose) + "\n";
}

}  // namespace equistream
