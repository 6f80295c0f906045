#include "checked.h"

#include <client/stages/stages.h>
#include <equistream/pose_limits.h>

#include <cmath>
#include <cstring>

namespace equistream {

namespace {

constexpr int max_eye_side = 16384;
constexpr std::size_t max_text = 65536;

void require(bool right, const std::string& field, const std::string& expected, const std::string& found) {
    if (!right)
        throw InputError(expected_found(field, expected, found));
}

void require(const std::optional<Mismatch>& mismatch, const std::string& field) {
    if (mismatch)
        throw InputError(expected_found(field, mismatch->expected, mismatch->found));
}

std::string checked_text(const char* field, const char* text) {
    if (text == nullptr)
        return "";
    require(strnlen(text, max_text + 1) <= max_text, field, "at most " + std::to_string(max_text) + " bytes", "more");
    return text;
}

FieldOfView checked_fov(const std::string& field, const es_field_of_view& fov) {
    constexpr double max_rad = 85 * pi / 180, min_span_rad = 1e-3;
    for (const double angle : {fov.left, fov.right, fov.up, fov.down})
        require(range_mismatch(angle, -max_rad, max_rad), field);
    require(fov.right - fov.left >= min_span_rad && fov.up - fov.down >= min_span_rad, field,
            "left below right, and down below up", "the other way round, or nothing between them");
    return {fov.left, fov.right, fov.up, fov.down};
}

}  // namespace

Pose checked_pose(const std::string& field, const es_pose& pose) {
    const double* p = pose.position_m;
    const double* q = pose.orientation_wxyz;
    const glm::dvec3 position_m(p[0], p[1], p[2]);
    const glm::dquat orientation(q[0], q[1], q[2], q[3]);
    require(position_mismatch(position_m), field + ".position_m");
    require(orientation_mismatch(orientation), field + ".orientation_wxyz");
    return {position_m, orientation / glm::length(orientation)};
}

es_pose pose_of(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{p.x, p.y, p.z}, {q.w, q.x, q.y, q.z}};
}

CheckedSettings checked_settings(const es_client_settings* settings) {
    const std::size_t sizes[] = {sizeof(es_client_settings)};
    const es_client_settings s = whole_struct(settings, "es_client_settings", sizes);
    require(s.abi_version == ES_CLIENT_ABI_VERSION, "abi_version", std::to_string(ES_CLIENT_ABI_VERSION),
            std::to_string(s.abi_version));
    int backend = 0;  // a C caller may store any int in an enum
    std::memcpy(&backend, &s.backend, sizeof backend);
    require(backend == ES_BACKEND_CPU || backend == ES_BACKEND_OPENGL, "backend", "ES_BACKEND_CPU or ES_BACKEND_OPENGL",
            std::to_string(backend));
    CheckedSettings checked;
    checked.by_gl = backend == ES_BACKEND_OPENGL;
    SessionSettings& session = checked.session;
    session.source = checked_text("source", s.source);
    require(!session.source.empty(), "source", "a file, a folder or a URL", s.source == nullptr ? "NULL" : "no text");
    session.scene = checked_text("scene", s.scene);
    session.engine = checked_text("engine", s.engine);
    if (s.fill != nullptr)
        session.fill = checked_text("fill", s.fill);
    if (s.mirrors != nullptr)
        session.mirrors = find_mirror_treatment(checked_text("mirrors", s.mirrors));
    session.confidence = s.confidence != 0;
    session.paused = s.paused != 0;
    session.loop = s.loop != 0;
    session.hardware = s.software == 0;
    require(range_mismatch(s.max_extrapolation_s, 0, 1), "max_extrapolation_s");
    session.max_extrapolation_s = s.max_extrapolation_s;
    require(range_mismatch(s.exposure_stops, -max_exposure_stops, max_exposure_stops), "exposure_stops");
    session.exposure_stops = s.exposure_stops;
    return checked;
}

SessionRequest checked_request(const es_client_request* request) {
    const std::size_t sizes[] = {sizeof(es_client_request)};
    const es_client_request r = whole_struct(request, "es_client_request", sizes);
    require(range_mismatch(r.display_s, 0, 1e9), "display_s");
    SessionRequest checked;
    checked.display_s = r.display_s;
    checked.head = checked_pose("head", r.head);
    for (int i = 0; i < 2; ++i) {
        const std::string field = "eyes[" + std::to_string(i) + "]";
        checked.eyes[std::size_t(i)] = {checked_pose(field + ".in_head", r.eyes[i].in_head),
                                        checked_fov(field + ".fov", r.eyes[i].fov)};
    }
    for (const auto& [field, side] : {std::pair{"width", r.width}, {"height", r.height}})
        require(side >= 1 && side <= max_eye_side, field, "1 to " + std::to_string(max_eye_side), std::to_string(side));
    checked.width = r.width;
    checked.height = r.height;
    return checked;
}

}  // namespace equistream
