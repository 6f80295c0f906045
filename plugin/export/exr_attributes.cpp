#include "exr_attributes.h"

#include <equistream/window.h>

#include <cmath>
#include <limits>
#include <string_view>

namespace equistream {
namespace {

constexpr int format_version = 1;
constexpr exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// 29.97 is 30000/1001 and so on; anything else to a millionth.
exr_attr_rational_t rational_rate(double frames_per_second) {
    for (const int denominator : {1, 1001}) {
        const double scaled = frames_per_second * denominator;
        const double numerator = denominator == 1 ? std::round(scaled) : 1000 * std::round(scaled / 1000);
        if (std::abs(scaled - numerator) < 2e-6 * scaled && numerator < 2e9)
            return {static_cast<std::int32_t>(numerator), static_cast<std::uint32_t>(denominator)};
    }
    const double limited = std::min(frames_per_second, 2000.0);
    return {static_cast<std::int32_t>(std::lround(limited * 1e6)), 1000000u};
}

void write_camera(AttributeWriter& out, const FrameInfo& info) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&info.camera)) {
        const LongitudeLatitudeRange& range = sphere->range;
        if (is_centred_full_sphere(range) && !info.patches)
            out.check(exr_attr_set_envmap(out.context(), out.part(), "envmap", EXR_ENVMAP_LATLONG), "envmap");
        out.text("wrapmodes", range.closes() && !info.patches ? "periodic,clamp" : "clamp,clamp");
        out.text("equistream:camera", is_ods(info.camera) ? "ods" : "equirect");
        out.pair("equistream:longitudes", range.longitude_min, range.longitude_max);
        out.pair("equistream:latitudes", range.latitude_min, range.latitude_max);
        return;
    }
    out.text("equistream:camera", "perspective");
    out.number("equistream:fovX", std::get<PerspectiveCamera>(info.camera).fov_x_rad);
}

/// What a reader without our documentation needs in order to use the planes.
void write_conventions(AttributeWriter& out, bool ods) {
    out.text("equistream:pixelCentres", "half-integer");
    out.text("equistream:axes", "right-handed, +Y up; camera +X right, -Z forward; longitude 0 is -Z, positive to +X");
    out.text("equistream:depth",
             ods ? "Euclidean distance from the eye of the pixel-centre ray on the viewing circle, metres, +inf: miss"
                 : "Euclidean distance from the camera along the pixel-centre ray, metres, +inf: miss");
    out.text("equistream:motion", "pixels, other frame minus this one, u right, v down, shortest way round the seam");
    out.text("equistream:normal", "world space, facing the camera");
}

Camera read_camera(const AttributeReader& in, int width, int height) {
    constexpr const char* kinds[] = {"equirect", "perspective", "ods"};
    if (in.choice("equistream:camera", kinds) == 1)
        return PerspectiveCamera{width, height, in.field_of_view("equistream:fovX")};
    const exr_attr_v2d_t longitudes = in.range("equistream:longitudes", longitudes_mismatch);
    const exr_attr_v2d_t latitudes = in.range("equistream:latitudes", latitudes_mismatch);
    return EquirectCamera{width, height, {longitudes.x, longitudes.y, latitudes.x, latitudes.y}};
}

/// Columns of the sphere that the picture is a window of; its place must be one of theirs.
int read_window_columns(const AttributeReader& in, const FrameInfo& info) {
    constexpr const char* name = "equistream:windowColumns";
    const int columns = in.integer(name);
    const auto* camera = std::get_if<EquirectCamera>(&info.camera);
    if (camera == nullptr || info.patches)
        in.refuse(name, "a window of a sphere", camera == nullptr ? "a perspective camera" : "an atlas of patches");
    const WindowGrid grid{columns, columns / 2, camera->width, camera->height};
    if (columns > max_image_side)
        in.refuse(name, "at most " + std::to_string(max_image_side), std::to_string(columns));
    if (const auto problem = window_grid_problem(grid))
        throw InputError(in.file() + ": " + name + ": " + *problem);
    if (!window_place(grid, camera->range))
        in.refuse(name, "longitudes and latitudes of such a sphere's window", std::to_string(columns));
    return columns;
}

constexpr const char* sphere_size = "equistream:sphereSize";
constexpr const char* patch_side = "equistream:patchSide";
constexpr const char* patch_offsets = "equistream:patchOffsets";
constexpr const char* patch_slots = "equistream:patchSlots";

/// Numbers and the signs between them, from the front.
class Words {
public:
    Words(const AttributeReader& in, const char* name, const char* expected)
        : in_(in), name_(name), expected_(expected), text_(in.text(name)), left_(text_) {}

    bool at_end() const { return left_.empty(); }
    bool take(char sign) {
        const bool there = !left_.empty() && left_.front() == sign;
        if (there)
            left_.remove_prefix(1);
        return there;
    }
    void require(char sign) {
        if (!take(sign))
            refuse();
    }
    template <typename T>
    T number() {
        T value = 0;
        const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), value);
        if (error != std::errc())
            refuse();
        left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
        return value;
    }
    [[noreturn]] void refuse() const { in_.refuse(name_, expected_, "\"" + std::string(left_.substr(0, 40)) + "\""); }

private:
    const AttributeReader& in_;
    const char* name_;
    const char* expected_;
    std::string text_;
    std::string_view left_;
};

void read_offsets(const AttributeReader& in, PatchAtlas& atlas) {
    Words words(in, patch_offsets, "offsets \"x y z\" in metres, at most 64, between commas");
    do {
        glm::dvec3 offset;
        offset.x = words.number<double>();
        words.require(' ');
        offset.y = words.number<double>();
        words.require(' ');
        offset.z = words.number<double>();
        if (atlas.offsets_m.size() == static_cast<std::size_t>(max_patch_offsets))
            words.refuse();
        atlas.offsets_m.push_back(offset);
    } while (words.take(','));
    if (!words.at_end())
        words.refuse();
}

void read_slots(const AttributeReader& in, PatchAtlas& atlas) {
    Words words(in, patch_slots, "a slot \"-\" or \"offset:column:row\" for each patch of the picture, between commas");
    for (std::size_t i = 0; i < atlas.slots.size(); ++i) {
        if (i > 0)
            words.require(',');
        if (words.take('-'))
            continue;
        PatchAtlas::Slot& slot = atlas.slots[i];
        slot.used = true;
        slot.offset_index = words.number<std::uint8_t>();
        words.require(':');
        slot.block_x = words.number<std::uint16_t>();
        words.require(':');
        slot.block_y = words.number<std::uint16_t>();
    }
    if (!words.at_end())
        words.refuse();
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
    write_camera(out, info);
    out.pose("equistream:position", "equistream:orientation", info.camera_pose);
    out.pose("equistream:headPosition", "equistream:headOrientation", info.head);
    out.text("equistream:eye", eye_names[static_cast<int>(info.eye)]);
    out.number("equistream:ipd", info.ipd_m);
    out.text("equistream:lock", axis_lock_names[static_cast<int>(info.lock)]);
    out.number("equistream:headBoxRadius", info.head_radius_m);
    out.number("equistream:exposure", info.exposure);
    out.text("equistream:seed", std::to_string(info.seed));
    out.text("equistream:spp", std::to_string(info.samples_per_pixel));
    out.text("equistream:scene", info.scene);
    out.text("equistream:host", info.host);
    if (!info.geometry_fingerprint.empty())
        out.text("equistream:geometry", info.geometry_fingerprint);
    if (!info.denoiser.empty())
        out.text("equistream:denoiser", info.denoiser);
    if (info.accumulated_frames > 0)
        out.text("equistream:accumulatedFrames", std::to_string(info.accumulated_frames));
    if (info.window_columns > 0)
        out.integer("equistream:windowColumns", info.window_columns);
    if (info.patches)
        write_patches(out, *info.patches);
    write_conventions(out, is_ods(info.camera));
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
    info.index = in.frame_index("equistream:frame");
    info.time_s = in.number("equistream:time", -max_time_s, max_time_s);
    info.frames_per_second = in.number("equistream:fps", 1e-6, 1e6);
    if (has_patches(in)) {
        info.patches = read_patches(in, width, height);
        width = info.patches->sphere_width;
        height = info.patches->sphere_height;
    }
    info.camera = read_camera(in, width, height);
    info.camera_pose = in.pose("equistream:position", "equistream:orientation");
    info.head = in.pose("equistream:headPosition", "equistream:headOrientation");
    info.eye = static_cast<Eye>(in.choice("equistream:eye", eye_names));
    info.ipd_m = in.number("equistream:ipd", 0, max_ipd_m);
    if (in.text("equistream:camera") == "ods" && !make_ods(info))
        in.refuse(info.ipd_m > 0 ? "equistream:eye" : "equistream:ipd",
                  "with camera ods, left or right eyes that are apart",
                  info.ipd_m > 0 ? in.text("equistream:eye") : "0");
    info.lock = static_cast<AxisLock>(in.choice("equistream:lock", axis_lock_names));
    info.head_radius_m = in.number("equistream:headBoxRadius", 0, max_head_box_radius_m);
    info.exposure = in.number("equistream:exposure", std::numeric_limits<double>::min(), huge);
    info.seed = in.decimal<std::uint64_t>("equistream:seed");
    info.samples_per_pixel = in.decimal<std::uint32_t>("equistream:spp");
    info.scene = in.short_text("equistream:scene");
    info.host = in.short_text("equistream:host");
    if (in.has("equistream:geometry"))
        info.geometry_fingerprint = in.short_text("equistream:geometry");
    if (in.has("equistream:denoiser"))
        info.denoiser = in.short_text("equistream:denoiser");
    if (in.has("equistream:accumulatedFrames"))
        info.accumulated_frames = in.decimal<std::uint32_t>("equistream:accumulatedFrames");
    if (in.has("equistream:windowColumns"))
        info.window_columns = read_window_columns(in, info);
    if (info.patches) {
        const auto* sphere = std::get_if<EquirectCamera>(&info.camera);
        if (!sphere)
            in.refuse("equistream:camera", "equirect, which patches are of", "perspective");
        info.patches->range = sphere->range;
    }
    return info;
}

void write_patches(AttributeWriter& out, const PatchAtlas& atlas) {
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("patches: " + *problem);
    out.text(sphere_size, size_text(atlas.sphere_width, atlas.sphere_height));
    out.integer(patch_side, atlas.block_side);
    std::string text;
    for (const glm::dvec3& o : atlas.offsets_m)
        text += (text.empty() ? "" : ",") + formatted("%.17g %.17g %.17g", o.x, o.y, o.z);
    out.text(patch_offsets, text);
    text.clear();
    for (const PatchAtlas::Slot& slot : atlas.slots) {
        text += text.empty() ? "" : ",";
        text += slot.used ? formatted("%d:%d:%d", slot.offset_index, slot.block_x, slot.block_y) : "-";
    }
    out.text(patch_slots, text);
}

bool has_patches(const AttributeReader& in) {
    return in.has(patch_side);
}

PatchAtlas read_patches(const AttributeReader& in, int width, int height) {
    PatchAtlas atlas;
    atlas.block_side = in.integer(patch_side);
    if (atlas.block_side < min_patch_side || atlas.block_side > max_patch_side || width % atlas.block_side != 0 ||
        height % atlas.block_side != 0)
        in.refuse(patch_side, "a side of 4 to 64 pixels that divides the picture's " + size_text(width, height),
                  std::to_string(atlas.block_side));
    atlas.columns = width / atlas.block_side;
    atlas.rows = height / atlas.block_side;
    Words size(in, sphere_size, "a size such as 1920x960");
    atlas.sphere_width = size.number<int>();
    size.require('x');
    atlas.sphere_height = size.number<int>();
    read_offsets(in, atlas);
    if (atlas.columns > max_patch_slots / atlas.rows)
        in.refuse(patch_slots, "at most " + std::to_string(max_patch_slots) + " slots",
                  size_text(atlas.columns, atlas.rows));
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    read_slots(in, atlas);
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError(in.file() + ": patches: " + *problem);
    return atlas;
}

}  // namespace equistream
