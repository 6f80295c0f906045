#include "frame_json.h"

namespace equistream {

nlohmann::json pose_to_json(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{"position_m", {p.x, p.y, p.z}}, {"orientation_wxyz", {q.w, q.x, q.y, q.z}}};
}

nlohmann::json visible_loss_to_json(const VisibleLoss& loss) {
    nlohmann::json shares = nlohmann::json::array();
    for (std::size_t i = 0; i < VisibleLoss::textures.size(); ++i)
        shares.push_back({{"texture", VisibleLoss::textures[i]}, {"visibly_off", loss.share_255[i] / 255.0f}});
    return shares;
}

nlohmann::json camera_to_json(const Camera& camera) {
    nlohmann::json json = {{"width", width_of(camera)}, {"height", height_of(camera)}};
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera)) {
        json["kind"] = is_ods(camera) ? "ods" : "equirect";
        json["longitudes_rad"] = {sphere->range.longitude_min, sphere->range.longitude_max};
        json["latitudes_rad"] = {sphere->range.latitude_min, sphere->range.latitude_max};
    } else {
        json["kind"] = "perspective";
        json["fov_x_rad"] = std::get<PerspectiveCamera>(camera).fov_x_rad;
    }
    return json;
}

nlohmann::json patches_to_json(const PatchAtlas& atlas) {
    nlohmann::json offsets = nlohmann::json::array();
    for (const glm::dvec3& offset : atlas.offsets_m)
        offsets.push_back({offset.x, offset.y, offset.z});
    return {{"side", atlas.block_side}, {"columns", atlas.columns}, {"rows", atlas.rows}, {"offsets_m", offsets}};
}

}  // namespace equistream
