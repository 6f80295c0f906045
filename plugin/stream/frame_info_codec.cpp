#include "motion_table.h"
#include "patch_table.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <plugin/export/unit_orientation.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

namespace equistream {

namespace {

// 69c48036-5133-4784-8093-ec66a7475119
constexpr std::array<std::uint8_t, 16> payload_uuid = {0x69, 0xc4, 0x80, 0x36, 0x51, 0x33, 0x47, 0x84,
                                                       0x80, 0x93, 0xec, 0x66, 0xa7, 0x47, 0x51, 0x19};
constexpr std::uint16_t payload_version = 1;
constexpr std::size_t longest_name = 255;
constexpr const char* payload_place = "frame data in the stream";

static_assert(std::endian::native == std::endian::little, "fields are copied as they lie in memory");

class Writer {
public:
    template <typename T>
    void put(T value) {
        static_assert(std::is_arithmetic_v<T>);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
        bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
    }

    void put_pose(const Pose& pose) {
        for (int i = 0; i < 3; ++i)
            put(pose.position_m[i]);
        for (const double q : {pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z})
            put(q);
    }

    void put_name(const std::string& name, const char* what) {
        if (name.size() > longest_name)
            throw InputError(
                expected_found(what, "a name of at most 255 bytes", std::to_string(name.size()) + " bytes"));
        put(static_cast<std::uint8_t>(name.size()));
        bytes_.insert(bytes_.end(), name.begin(), name.end());
    }

    void append(std::span<const std::uint8_t> more) { bytes_.insert(bytes_.end(), more.begin(), more.end()); }
    const std::vector<std::uint8_t>& bytes() const { return bytes_; }

private:
    std::vector<std::uint8_t> bytes_;
};

[[noreturn]] void damaged(const std::string& expected, const std::string& found) {
    throw WorkError(expected_found(payload_place, expected, found));
}

void require(const std::string& what, const std::optional<Mismatch>& mismatch) {
    if (mismatch)
        damaged(what + ": " + mismatch->expected, mismatch->found);
}

class Reader {
public:
    explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    std::span<const std::uint8_t> take(std::size_t size) {
        if (size > bytes_.size())
            damaged(std::to_string(size) + " more bytes", std::to_string(bytes_.size()));
        const auto taken = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return taken;
    }

    template <typename T>
    T get() {
        T value;
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
        return value;
    }

    double get_finite(const char* what) {
        const auto value = get<double>();
        if (!std::isfinite(value))
            damaged(std::string(what) + " to be finite", std::to_string(value));
        return value;
    }

    double get_number(const char* what, double min, double max) {
        const auto value = get<double>();
        require(what, range_mismatch(value, min, max));
        return value;
    }

    double get_positive(const char* what) {
        const double value = get_finite(what);
        if (!(value > 0))
            damaged(std::string(what) + " above 0", std::to_string(value));
        return value;
    }

    template <typename Enum>
    Enum get_enum(Enum last, const char* what) {
        const auto value = get<std::uint8_t>();
        if (value > static_cast<std::uint8_t>(last))
            damaged(std::string(what) + " up to " + std::to_string(static_cast<int>(last)), std::to_string(value));
        return static_cast<Enum>(value);
    }

    bool get_flag(const char* what) {
        const auto value = get<std::uint8_t>();
        if (value > 1)
            damaged(std::string(what) + " as 0 or 1", std::to_string(value));
        return value == 1;
    }

    int get_side(const char* what) {
        const auto value = get<std::uint32_t>();
        if (value < 1 || value > static_cast<std::uint32_t>(max_image_side))
            damaged(std::string(what) + " of 1 to " + std::to_string(max_image_side), std::to_string(value));
        return static_cast<int>(value);
    }

    Pose get_pose(const char* what) {
        Pose pose;
        for (int i = 0; i < 3; ++i)
            pose.position_m[i] = get<double>();
        for (double* q : {&pose.orientation.w, &pose.orientation.x, &pose.orientation.y, &pose.orientation.z})
            *q = get<double>();
        require(what, pose_mismatch(pose));
        pose.orientation = unit_orientation(pose.orientation);
        return pose;
    }

    bool at_end() const { return bytes_.empty(); }

    std::string get_name() {
        const auto size = get<std::uint8_t>();
        const auto text = take(size);
        return {text.begin(), text.end()};
    }

private:
    std::span<const std::uint8_t> bytes_;
};

enum class CameraKind : std::uint8_t { equirect = 0, perspective = 1, ods = 2 };

/// Four numbers: longitude and latitude limits, or the horizontal field of view and three zeros.
std::array<double, 4> camera_numbers(const Camera& camera) {
    if (const auto* perspective = std::get_if<PerspectiveCamera>(&camera))
        return {perspective->fov_x_rad, 0, 0, 0};
    const auto& range = std::get<EquirectCamera>(camera).range;
    return {range.longitude_min, range.longitude_max, range.latitude_min, range.latitude_max};
}

CameraKind kind_of(const Camera& camera) {
    return std::holds_alternative<PerspectiveCamera>(camera) ? CameraKind::perspective
           : is_ods(camera)                                  ? CameraKind::ods
                                                             : CameraKind::equirect;
}

Camera make_camera(CameraKind kind, int width, int height, const std::array<double, 4>& numbers) {
    if (std::int64_t{width} * height > max_image_pixels)
        damaged("a camera of at most " + std::to_string(max_image_pixels) + " pixels", size_text(width, height));
    const Camera camera = kind == CameraKind::perspective
                              ? Camera(PerspectiveCamera{width, height, numbers[0]})
                              : Camera(EquirectCamera{width, height, {numbers[0], numbers[1], numbers[2], numbers[3]}});
    require("camera", camera_mismatch(camera));
    return camera;
}

/// A byte that says whether there is one, then the fields.
void put_depth_code(Writer& out, const std::optional<DepthCodeInfo>& depth_code) {
    out.put(static_cast<std::uint8_t>(depth_code.has_value()));
    if (!depth_code)
        return;
    out.put(static_cast<std::uint8_t>(depth_code->code));
    out.put(static_cast<std::uint8_t>(depth_code->range.has_empty));
    out.put(depth_code->range.box_radius_m);
    out.put(depth_code->range.near_m);
    out.put(depth_code->clamped_pixels);
}

std::optional<DepthCodeInfo> get_depth_code(Reader& in) {
    if (!in.get_flag("whether depth is coded"))
        return std::nullopt;
    DepthCodeInfo info;
    info.code = in.get_enum(DepthCodeId::lossless, "depth code");
    info.range.has_empty = in.get_flag("whether pixels may hold no surface");
    info.range.box_radius_m = in.get_positive("head box radius");
    info.range.near_m = in.get_positive("nearest depth");
    // As floats, which depths are: else a sample of the nearest depth would lie inside the box, or nowhere.
    if (!(static_cast<float>(info.range.near_m) > static_cast<float>(info.range.box_radius_m) &&
          std::isfinite(static_cast<float>(info.range.near_m))))
        damaged("a nearest depth outside the head box of " + std::to_string(info.range.box_radius_m) + " m",
                std::to_string(info.range.near_m));
    info.clamped_pixels = in.get<std::uint32_t>();
    return info;
}

constexpr float no_crf = -1;

std::optional<float> get_crf(Reader& in) {
    const auto crf = in.get<float>();
    if (crf == no_crf)
        return std::nullopt;
    if (!(crf >= 0 && crf <= worst_crf))
        damaged("CRF of 0 to " + std::to_string(worst_crf) + ", or -1", std::to_string(crf));
    return crf;
}

/// A byte that says whether it was measured, then the losses.
void put_visible_loss(Writer& out, const std::optional<VisibleLoss>& loss) {
    out.put(static_cast<std::uint8_t>(loss.has_value()));
    if (loss)
        out.append(loss->share_255);
}

std::optional<VisibleLoss> get_visible_loss(Reader& in) {
    if (!in.get_flag("whether the visible loss was measured"))
        return std::nullopt;
    VisibleLoss loss;
    std::ranges::copy(in.take(loss.share_255.size()), loss.share_255.begin());
    return loss;
}

std::optional<PatchAtlas> get_patches(Reader& in, TrackRole role, const Camera& camera) {
    const auto bytes = in.take(in.get<std::uint16_t>());
    if (bytes.empty())
        return std::nullopt;
    if (role != TrackRole::patches && role != TrackRole::patches_depth)
        damaged("a table of patches with pictures of patches alone", track_name(role));
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    if (!sphere)
        damaged("patches of a sphere", "a perspective camera");
    return unpack_patch_table(bytes, *sphere);
}

std::vector<std::uint8_t> pack_motion(const FrameInfo& info) {
    return pack_motion_table(info.moving, width_of(info.camera), height_of(info.camera));
}

std::vector<MovingRegion> get_moving(Reader& in, TrackRole role, const Camera& camera) {
    const auto bytes = in.take(in.get<std::uint16_t>());
    if (!bytes.empty() && role != TrackRole::main)
        damaged("motion with main's pictures alone", track_name(role));
    return unpack_motion_table(bytes, width_of(camera), height_of(camera));
}

StereoPacking get_packing(Reader& in, TrackRole role) {
    const auto packing = in.get_enum(StereoPacking::top_bottom, "packing of both eyes");
    if (packing != StereoPacking::none && role != TrackRole::main && role != TrackRole::depth)
        damaged("both eyes in main's pictures and their depth alone", track_name(role));
    return packing;
}

TaggedFrameInfo read_fields(Reader& in) {
    TaggedFrameInfo tagged;
    FrameInfo& info = tagged.info;
    tagged.role = in.get_enum(TrackRole::window_reflections, "track role");
    const auto kind = in.get_enum(CameraKind::ods, "camera kind");
    info.eye = in.get_enum(Eye::right, "eye");
    info.lock = in.get_enum(AxisLock::path, "axis lock");
    const int width = in.get_side("camera width");
    const int height = in.get_side("camera height");
    tagged.position.ordinal = in.get<std::uint32_t>();
    tagged.position.count = in.get<std::uint32_t>();
    info.index = in.get<std::int64_t>();
    require("frame index", range_mismatch(static_cast<double>(info.index), 0, max_frame_index));
    info.time_s = in.get_number("time", -max_time_s, max_time_s);
    info.frames_per_second = in.get_number("frames per second", 1e-6, 1e6);
    std::array<double, 4> numbers;
    for (double& number : numbers)
        number = in.get_finite("camera");
    info.camera = make_camera(kind, width, height, numbers);
    info.camera_pose = in.get_pose("camera pose");
    info.head = in.get_pose("head pose");
    info.ipd_m = in.get_number("interpupillary distance", 0, max_ipd_m);
    if (kind == CameraKind::ods && !make_ods(info))
        damaged("omnidirectional stereo of a left or right eye, of eyes that are apart", "others");
    info.head_radius_m = in.get_number("head box radius", 0, max_head_box_radius_m);
    info.exposure = in.get_positive("exposure");
    info.seed = in.get<std::uint64_t>();
    info.samples_per_pixel = in.get<std::uint32_t>();
    info.scene = in.get_name();
    info.host = in.get_name();
    // Appended since, each in its turn: earlier streams end before it.
    if (!in.at_end())
        info.geometry_fingerprint = in.get_name();
    if (!in.at_end())
        info.depth_code = get_depth_code(in);
    if (!in.at_end())
        info.patches = get_patches(in, tagged.role, info.camera);
    if (!in.at_end() && in.get_flag("whether depth is halved")) {
        if (!info.depth_code)
            damaged("depth, where it is halved", "none");
        info.depth_code->halved = true;
    }
    if (!in.at_end())
        info.crf = get_crf(in);
    if (!in.at_end())
        info.visible_loss = get_visible_loss(in);
    if (!in.at_end())
        info.moving = get_moving(in, tagged.role, info.camera);
    if (!in.at_end())
        info.denoiser = in.get_name();
    if (!in.at_end())
        info.packing = get_packing(in, tagged.role);
    return tagged;
}

bool starts_with_our_uuid(std::span<const std::uint8_t> payload) {
    return payload.size() >= payload_uuid.size() &&
           std::equal(payload_uuid.begin(), payload_uuid.end(), payload.begin());
}

}  // namespace

const char* track_name(TrackRole role) {
    constexpr const char* names[] = {"main",          "small",  "depth",  "hidden",       "hidden-depth", "patches",
                                     "patches-depth", "images", "window", "window-depth", "window-images"};
    static_assert(std::size(names) == track_role_count);
    return names[static_cast<std::size_t>(role)];
}

bool is_depth(TrackRole role) {
    return may_be_halved(role) || is_reflections(role) || role == TrackRole::hidden_depth ||
           role == TrackRole::patches_depth;
}

bool may_be_halved(TrackRole role) {
    return role == TrackRole::depth || role == TrackRole::window_depth;
}

bool may_be_tiled(TrackRole role) {
    return role == TrackRole::window || role == TrackRole::window_depth || role == TrackRole::window_reflections;
}

bool is_reflections(TrackRole role) {
    return role == TrackRole::reflections || role == TrackRole::window_reflections;
}

std::optional<TrackRole> reflections_role_of(TrackRole colour) {
    return colour == TrackRole::main     ? std::optional(TrackRole::reflections)
           : colour == TrackRole::window ? std::optional(TrackRole::window_reflections)
                                         : std::nullopt;
}

std::optional<TrackRole> depth_role_of(TrackRole colour) {
    switch (colour) {
    case TrackRole::main:
        return TrackRole::depth;
    case TrackRole::hidden:
        return TrackRole::hidden_depth;
    case TrackRole::patches:
        return TrackRole::patches_depth;
    case TrackRole::window:
        return TrackRole::window_depth;
    default:
        return std::nullopt;
    }
}

std::size_t motion_bytes(const FrameInfo& info) {
    return pack_motion(info).size();
}

std::vector<std::uint8_t> encode_frame_info(TrackRole role, const FrameInfo& info, TrackPosition position) {
    Writer fields;
    fields.put(static_cast<std::uint8_t>(role));
    fields.put(static_cast<std::uint8_t>(kind_of(info.camera)));
    fields.put(static_cast<std::uint8_t>(info.eye));
    fields.put(static_cast<std::uint8_t>(info.lock));
    fields.put(static_cast<std::uint32_t>(width_of(info.camera)));
    fields.put(static_cast<std::uint32_t>(height_of(info.camera)));
    fields.put(position.ordinal);
    fields.put(position.count);
    fields.put(info.index);
    fields.put(info.time_s);
    fields.put(info.frames_per_second);
    for (const double number : camera_numbers(info.camera))
        fields.put(number);
    fields.put_pose(info.camera_pose);
    fields.put_pose(info.head);
    fields.put(info.ipd_m);
    fields.put(info.head_radius_m);
    fields.put(info.exposure);
    fields.put(info.seed);
    fields.put(info.samples_per_pixel);
    fields.put_name(info.scene, "scene");
    fields.put_name(info.host, "host");
    fields.put_name(info.geometry_fingerprint, "geometry fingerprint");
    put_depth_code(fields, info.depth_code);
    if (info.patches && role != TrackRole::patches && role != TrackRole::patches_depth)
        throw InputError(expected_found("frame " + std::to_string(info.index) + " of " + track_name(role),
                                        "a whole picture", "an atlas of patches"));
    const auto patches = info.patches ? pack_patch_table(*info.patches) : std::vector<std::uint8_t>();
    fields.put(static_cast<std::uint16_t>(patches.size()));
    fields.append(patches);
    fields.put(static_cast<std::uint8_t>(info.depth_code && info.depth_code->halved));
    fields.put(info.crf.value_or(no_crf));
    put_visible_loss(fields, info.visible_loss);
    const auto moving = role == TrackRole::main ? pack_motion(info) : std::vector<std::uint8_t>();
    if (moving.size() > max_motion_bytes)
        throw InputError(expected_found("motion", "at most " + std::to_string(max_motion_bytes) + " bytes",
                                        std::to_string(moving.size())));
    fields.put(static_cast<std::uint16_t>(moving.size()));
    fields.append(moving);
    fields.put_name(info.denoiser, "denoiser");
    fields.put(static_cast<std::uint8_t>(info.packing));

    Writer payload;
    payload.append(payload_uuid);
    payload.put(payload_version);
    payload.put(static_cast<std::uint16_t>(fields.bytes().size()));
    payload.append(fields.bytes());
    return payload.bytes();
}

std::optional<TaggedFrameInfo> decode_frame_info(std::span<const std::uint8_t> payload) {
    // libx265 puts a UUID of its own before ours.
    if (!starts_with_our_uuid(payload) && payload.size() > payload_uuid.size())
        payload = payload.subspan(payload_uuid.size());
    if (!starts_with_our_uuid(payload))
        return std::nullopt;
    Reader header(payload.subspan(payload_uuid.size()));
    const auto version = header.get<std::uint16_t>();
    if (version != payload_version)
        throw InputError(expected_found(payload_place,
                                        "version " + std::to_string(payload_version) + ", which this program reads",
                                        "version " + std::to_string(version)));
    const auto size = header.get<std::uint16_t>();
    Reader fields(header.take(size));
    return read_fields(fields);
}

}  // namespace equistream
