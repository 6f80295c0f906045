#include "exr_attributes.h"

#include <equistream/error.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

namespace equistream {
namespace {

constexpr int format_version = 1;
constexpr exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// 29.97 is 30000/1001 and so on; anything else to a millionth.
exr_attr_rational_t rational_rate(double frames_per_second) {
    for (const int denominator : {1, 1001}) {
        const double scaled = frames_per_second * denominator;
        const double numerator = denominator == 1 ? std::round(scaled) : 1000 * std::round(scaled / 1000);
        if (std::abs(scaled - numerator) < 1e-6 * scaled && numerator < 2e9)
            return {static_cast<std::int32_t>(numerator), static_cast<std::uint32_t>(denominator)};
    }
    const double limited = std::min(frames_per_second, 2000.0);
    return {static_cast<std::int32_t>(std::lround(limited * 1e6)), 1000000u};
}

class AttributeWriter {
public:
    AttributeWriter(const ExrSession& session, int part) : session_(session), part_(part) {}

    void text(const char* name, const std::string& value) {
        check(exr_attr_set_string(session_.context(), part_, name, value.c_str()), name);
    }
    void number(const char* name, double value) {
        check(exr_attr_set_double(session_.context(), part_, name, value), name);
    }
    void integer(const char* name, std::int32_t value) {
        check(exr_attr_set_int(session_.context(), part_, name, value), name);
    }
    void pair(const char* name, double first, double second) {
        exr_attr_v2d_t value{};
        value.x = first;
        value.y = second;
        check(exr_attr_set_v2d(session_.context(), part_, name, &value), name);
    }
    void pose(const char* position_name, const char* orientation_name, const Pose& pose) {
        exr_attr_v3d_t position{};
        position.x = pose.position_m.x;
        position.y = pose.position_m.y;
        position.z = pose.position_m.z;
        check(exr_attr_set_v3d(session_.context(), part_, position_name, &position), position_name);
        const glm::dquat& q = pose.orientation;
        char quaternion[128];
        std::snprintf(quaternion, sizeof quaternion, "%.17g %.17g %.17g %.17g", q.w, q.x, q.y, q.z);
        text(orientation_name, quaternion);
    }
    void check(exr_result_t result, const char* name) { session_.check(result, name); }
    exr_context_t context() const { return session_.context(); }
    int part() const { return part_; }

private:
    const ExrSession& session_;
    int part_;
};

void write_camera(AttributeWriter& out, const Camera& camera) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera)) {
        const LongitudeLatitudeRange& range = sphere->range;
        if (range.is_full_sphere())
            out.check(exr_attr_set_envmap(out.context(), out.part(), "envmap", EXR_ENVMAP_LATLONG), "envmap");
        out.text("wrapmodes", range.closes() ? "periodic,clamp" : "clamp,clamp");
        out.text("equistream:camera", "equirect");
        out.pair("equistream:longitudes", range.longitude_min, range.longitude_max);
        out.pair("equistream:latitudes", range.latitude_min, range.latitude_max);
        return;
    }
    out.text("equistream:camera", "perspective");
    out.number("equistream:fovX", std::get<PerspectiveCamera>(camera).fov_x_rad);
}

/// What a reader without our documentation needs in order to use the planes.
void write_conventions(AttributeWriter& out) {
    out.text("equistream:pixelCentres", "half-integer");
    out.text("equistream:axes", "right-handed, +Y up; camera +X right, -Z forward; longitude 0 is -Z, positive to +X");
    out.text("equistream:depth", "Euclidean distance from the camera along the pixel-centre ray, metres, +inf: miss");
    out.text("equistream:motion", "pixels, other frame minus this one, u right, v down, shortest way round the seam");
    out.text("equistream:normal", "world space, facing the camera");
}

class AttributeReader {
public:
    explicit AttributeReader(const ExrSession& session) : session_(session) {}

    bool has(const char* name) const {
        const exr_attribute_t* attribute = nullptr;
        const bool present = exr_get_attribute_by_name(session_.context(), 0, name, &attribute) == EXR_ERR_SUCCESS;
        session_.forget_errors();
        return present;
    }
    std::string text(const char* name) const {
        std::int32_t length = 0;
        const char* value = nullptr;
        require(exr_attr_get_string(session_.context(), 0, name, &length, &value), name, "a string");
        return value == nullptr ? std::string() : std::string(value, static_cast<std::size_t>(std::max(length, 0)));
    }
    std::string short_text(const char* name) const {
        std::string value = text(name);
        if (value.size() > 255)
            refuse(name, "at most 255 bytes", std::to_string(value.size()));
        return value;
    }
    double number(const char* name, double lowest, double highest) const {
        double value = 0;
        require(exr_attr_get_double(session_.context(), 0, name, &value), name, "a double");
        if (!(value >= lowest && value <= highest))
            refuse(name, "a number from " + std::to_string(lowest) + " to " + std::to_string(highest),
                   std::to_string(value));
        return value;
    }
    std::int32_t integer(const char* name) const {
        std::int32_t value = 0;
        require(exr_attr_get_int(session_.context(), 0, name, &value), name, "an int");
        return value;
    }
    template <typename T>
    T decimal(const char* name) const {
        const std::string digits = text(name);
        T value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc() || end != digits.data() + digits.size())
            refuse(name, "a whole number", "\"" + digits.substr(0, 40) + "\"");
        return value;
    }
    template <std::size_t N>
    int choice(const char* name, const char* const (&names)[N]) const {
        const std::string word = text(name);
        for (std::size_t i = 0; i < N; ++i)
            if (word == names[i])
                return static_cast<int>(i);
        refuse(name, std::string("one of ") + names[0] + " ... " + names[N - 1], "\"" + word.substr(0, 40) + "\"");
    }
    exr_attr_v2d_t range(const char* name, double limit) const {
        exr_attr_v2d_t value{};
        require(exr_attr_get_v2d(session_.context(), 0, name, &value), name, "a v2d");
        if (!(value.x < value.y && value.x >= -limit && value.y <= limit))
            refuse(name, "an ascending range in radians", std::to_string(value.x) + " " + std::to_string(value.y));
        return value;
    }
    Pose pose(const char* position_name, const char* orientation_name) const {
        exr_attr_v3d_t position{};
        require(exr_attr_get_v3d(session_.context(), 0, position_name, &position), position_name, "a v3d");
        if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
            refuse(position_name, "a finite position", "NaN or infinity");
        const std::string words = text(orientation_name);
        glm::dquat q{1, 0, 0, 0};
        const int found = std::sscanf(words.c_str(), "%lf %lf %lf %lf", &q.w, &q.x, &q.y, &q.z);
        if (found != 4 || !(std::abs(glm::length(q) - 1) < 1e-3))
            refuse(orientation_name, "a unit quaternion w x y z", "\"" + words.substr(0, 80) + "\"");
        return {{position.x, position.y, position.z}, q};
    }
    [[noreturn]] void refuse(const char* name, const std::string& expected, const std::string& found) const {
        throw InputError(expected_found(session_.file().string() + ": " + name, expected, found));
    }

private:
    void require(exr_result_t result, const char* name, const char* kind) const {
        if (result == EXR_ERR_SUCCESS)
            return;
        refuse(name, kind, result == EXR_ERR_NO_ATTR_BY_NAME ? "none" : exr_get_default_error_message(result));
    }

    const ExrSession& session_;
};

Camera read_camera(const AttributeReader& in, int width, int height) {
    constexpr const char* kinds[] = {"equirect", "perspective"};
    if (in.choice("equistream:camera", kinds) == 1)
        return PerspectiveCamera{width, height, in.number("equistream:fovX", 1e-6, pi - 1e-6)};
    const exr_attr_v2d_t longitudes = in.range("equistream:longitudes", 2 * pi + 1e-9);
    const exr_attr_v2d_t latitudes = in.range("equistream:latitudes", pi / 2 + 1e-9);
    return EquirectCamera{width, height, {longitudes.x, longitudes.y, latitudes.x, latitudes.y}};
}

}  // namespace

void write_attributes(const ExrSession& session, int part, const FrameInfo& info) {
    AttributeWriter out(session, part);
    out.check(exr_attr_set_chromaticities(out.context(), part, "chromaticities", &rec709), "chromaticities");
    const exr_attr_rational_t rate = rational_rate(info.frames_per_second);
    out.check(exr_attr_set_rational(out.context(), part, "framesPerSecond", &rate), "framesPerSecond");
    out.text("view", eye_names[static_cast<int>(info.eye)]);
    out.integer("equistream:version", format_version);
    out.text("equistream:frame", std::to_string(info.index));
    out.number("equistream:time", info.time_s);
    out.number("equistream:fps", info.frames_per_second);
    write_camera(out, info.camera);
    out.pose("equistream:position", "equistream:orientation", info.camera_pose);
    out.pose("equistream:headPosition", "equistream:headOrientation", info.head);
    out.text("equistream:eye", eye_names[static_cast<int>(info.eye)]);
    out.number("equistream:ipd", info.ipd_m);
    out.text("equistream:lock", axis_lock_names[static_cast<int>(info.lock)]);
    out.number("equistream:headBoxRadius", info.lean_m);
    out.number("equistream:exposure", info.exposure);
    out.text("equistream:seed", std::to_string(info.seed));
    out.text("equistream:spp", std::to_string(info.samples_per_pixel));
    out.text("equistream:scene", info.scene);
    out.text("equistream:host", info.host);
    if (!info.geometry_fingerprint.empty())
        out.text("equistream:geometry", info.geometry_fingerprint);
    write_conventions(out);
}

void write_left_out_samples(const ExrSession& session, int part, std::int64_t count) {
    AttributeWriter(session, part).text("equistream:leftOutSamples", std::to_string(count));
}

bool has_attributes(const ExrSession& session) {
    std::int32_t version = 0;
    const bool present = exr_attr_get_int(session.context(), 0, "equistream:version", &version) == EXR_ERR_SUCCESS;
    session.forget_errors();
    return present;
}

FrameInfo read_attributes(const ExrSession& session, int width, int height) {
    const AttributeReader in(session);
    const std::int32_t version = in.integer("equistream:version");
    if (version != format_version)
        in.refuse("equistream:version", std::to_string(format_version), std::to_string(version));
    constexpr double huge = std::numeric_limits<double>::max();
    FrameInfo info;
    info.index = in.decimal<std::int64_t>("equistream:frame");
    info.time_s = in.number("equistream:time", -huge, huge);
    info.frames_per_second = in.number("equistream:fps", 1e-6, 1e6);
    info.camera = read_camera(in, width, height);
    info.camera_pose = in.pose("equistream:position", "equistream:orientation");
    info.head = in.pose("equistream:headPosition", "equistream:headOrientation");
    info.eye = static_cast<Eye>(in.choice("equistream:eye", eye_names));
    info.ipd_m = in.number("equistream:ipd", 0, 1e3);
    info.lock = static_cast<AxisLock>(in.choice("equistream:lock", axis_lock_names));
    info.lean_m = in.number("equistream:headBoxRadius", 0, 1e6);
    info.exposure = in.number("equistream:exposure", std::numeric_limits<double>::min(), huge);
    info.seed = in.decimal<std::uint64_t>("equistream:seed");
    info.samples_per_pixel = in.decimal<std::uint32_t>("equistream:spp");
    info.scene = in.short_text("equistream:scene");
    info.host = in.short_text("equistream:host");
    if (in.has("equistream:geometry"))
        info.geometry_fingerprint = in.short_text("equistream:geometry");
    return info;
}

}  // namespace equistream
