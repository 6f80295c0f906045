#include "frame_json.h"
#include "unit_orientation.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace equistream {
namespace {

using nlohmann::json;

constexpr const char* format_name = "equistream sequence";
constexpr int format_version = 1;
constexpr std::uintmax_t max_manifest_bytes = 1 << 20;
/// What is quoted in a complaint is written by recursion.
constexpr int nesting_limit = 32;

/// A JSON object that is read key by key; every complaint names the file and the key.
class Section {
public:
    Section(const json& object, std::string where) : object_(object), where_(std::move(where)) {
        if (!object_.is_object())
            throw InputError(expected_found(where_, "an object", object_.type_name()));
    }

    const json& at(const char* key) const {
        const auto found = object_.find(key);
        if (found == object_.end())
            throw InputError(expected_found(where_, "key \"" + std::string(key) + "\"", "none"));
        return *found;
    }
    Section section(const char* key) const { return Section(at(key), where_ + ": " + key); }
    double number(const char* key) const {
        const json& value = at(key);
        if (!value.is_number() || !std::isfinite(value.get<double>()))
            refuse(key, "a number");
        return value.get<double>();
    }
    double number(const char* key, double min, double max) const {
        const double value = number(key);
        require(range_mismatch(value, min, max), key);
        return value;
    }
    void require(const std::optional<Mismatch>& mismatch, const char* key) const {
        if (mismatch)
            refuse(key, mismatch->expected);
    }
    /// `lowest` is not negative.
    template <typename T>
    T whole(const char* key, T lowest, T highest) const {
        const json& value = at(key);
        const bool fits = value.is_number_unsigned() &&
                          value.get<std::uint64_t>() >= static_cast<std::uint64_t>(lowest) &&
                          value.get<std::uint64_t>() <= static_cast<std::uint64_t>(highest);
        if (!fits)
            refuse(key, "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
        return value.get<T>();
    }
    std::string text(const char* key) const {
        const json& value = at(key);
        if (!value.is_string())
            refuse(key, "a string");
        return value.get<std::string>();
    }
    std::vector<std::string> texts(const char* key, const char* expected) const {
        const json& value = at(key);
        if (!value.is_array() || !std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_string(); }))
            refuse(key, expected);
        return value.get<std::vector<std::string>>();
    }
    bool truth(const char* key) const {
        const json& value = at(key);
        if (!value.is_boolean())
            refuse(key, "true or false");
        return value.get<bool>();
    }
    template <std::size_t N>
    std::vector<double> numbers(const char* key) const {
        const json& value = at(key);
        const bool right = value.is_array() && value.size() == N &&
                           std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
        if (!right)
            refuse(key, std::to_string(N) + " numbers");
        return value.get<std::vector<double>>();
    }
    template <std::size_t N>
    int choice(const char* key, const char* const (&names)[N]) const {
        const std::string word = text(key);
        for (std::size_t i = 0; i < N; ++i)
            if (word == names[i])
                return static_cast<int>(i);
        refuse(key, std::string("one of ") + names[0] + " ... " + names[N - 1]);
    }
    [[noreturn]] void refuse(const char* key, const std::string& expected) const {
        throw InputError(expected_found(where_ + ": " + key, expected, json_text(at(key)).substr(0, 80)));
    }

private:
    const json& object_;
    std::string where_;
};

Pose pose_from_json(const Section& in) {
    const auto p = in.numbers<3>("position_m");
    const auto q = in.numbers<4>("orientation_wxyz");
    const Pose pose{{p[0], p[1], p[2]}, glm::dquat(q[0], q[1], q[2], q[3])};
    in.require(position_mismatch(pose.position_m), "position_m");
    in.require(orientation_mismatch(pose.orientation), "orientation_wxyz");
    return {pose.position_m, unit_orientation(pose.orientation)};
}

Camera camera_from_json(const Section& in) {
    constexpr const char* kinds[] = {"equirect", "perspective", "ods"};
    const int width = in.whole<int>("width", 1, max_image_side);
    const int height = in.whole<int>("height", 1, max_image_side);
    if (in.choice("kind", kinds) == 1) {
        const double fov_x_rad = in.number("fov_x_rad");
        in.require(fov_mismatch(fov_x_rad), "fov_x_rad");
        return PerspectiveCamera{width, height, fov_x_rad};
    }
    const auto longitudes = in.numbers<2>("longitudes_rad");
    const auto latitudes = in.numbers<2>("latitudes_rad");
    in.require(longitudes_mismatch(longitudes[0], longitudes[1]), "longitudes_rad");
    in.require(latitudes_mismatch(latitudes[0], latitudes[1]), "latitudes_rad");
    return EquirectCamera{width, height, {longitudes[0], longitudes[1], latitudes[0], latitudes[1]}};
}

/// Its slots are all unused.
PatchAtlas patches_from_json(const Section& in, const Camera& camera) {
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    if (!sphere)
        in.refuse("side", "patches of an equirect camera");
    PatchAtlas atlas;
    atlas.sphere_width = sphere->width;
    atlas.sphere_height = sphere->height;
    atlas.range = sphere->range;
    atlas.block_side = in.whole<int>("side", min_patch_side, max_patch_side);
    atlas.columns = in.whole<int>("columns", 1, max_patch_slots);
    atlas.rows = in.whole<int>("rows", 1, max_patch_slots / atlas.columns);
    const json& offsets = in.at("offsets_m");
    const auto is_number = [](const json& v) { return v.is_number(); };
    const auto is_offset = [&](const json& v) {
        return v.is_array() && v.size() == 3 && std::all_of(v.begin(), v.end(), is_number);
    };
    if (!offsets.is_array() || offsets.size() > std::size_t{max_patch_offsets} ||
        !std::all_of(offsets.begin(), offsets.end(), is_offset))
        in.refuse("offsets_m", "a list of at most " + std::to_string(max_patch_offsets) + " times three numbers");
    for (const json& o : offsets)
        atlas.offsets_m.emplace_back(o[0].get<double>(), o[1].get<double>(), o[2].get<double>());
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    if (const auto problem = patch_atlas_problem(atlas))
        in.refuse("offsets_m", "patches that fit together: " + *problem);
    return atlas;
}

/// `camera` is the window's, straight ahead.
int window_columns_from_json(const Section& in, const Camera& camera) {
    const int columns = in.whole<int>("window_columns", window_block_px, max_image_side);
    const auto* window = std::get_if<EquirectCamera>(&camera);
    if (window == nullptr)
        in.refuse("window_columns", "a window of an equirect camera");
    const WindowGrid grid{columns, columns / 2, window->width, window->height};
    if (const auto problem = window_grid_problem(grid))
        in.refuse("window_columns", "a window's sphere: " + *problem);
    const LongitudeLatitudeRange &ahead = window_shape(grid).range, &range = window->range;
    if (std::abs(ahead.longitude_min - range.longitude_min) > 1e-9 ||
        std::abs(ahead.longitude_max - range.longitude_max) > 1e-9 ||
        std::abs(ahead.latitude_min - range.latitude_min) > 1e-9 ||
        std::abs(ahead.latitude_max - range.latitude_max) > 1e-9)
        in.refuse("window_columns", "a camera that covers its window, straight ahead");
    return columns;
}

json to_json(const Manifest& manifest) {
    const FrameInfo& info = manifest.shared;
    json document = {{"format", format_name},
                     {"version", format_version},
                     {"camera", camera_to_json(info.camera)},
                     {"first_frame",
                      {{"index", info.index},
                       {"time_s", info.time_s},
                       {"camera_pose", pose_to_json(info.camera_pose)},
                       {"head", pose_to_json(info.head)}}},
                     {"frames_per_second", info.frames_per_second},
                     {"eye", eye_names[static_cast<int>(info.eye)]},
                     {"ipd_m", info.ipd_m},
                     {"lock", axis_lock_names[static_cast<int>(info.lock)]},
                     {"lean_m", info.head_radius_m},
                     {"exposure", info.exposure},
                     {"seed", info.seed},
                     {"samples_per_pixel", info.samples_per_pixel},
                     {"scene", info.scene},
                     {"host", info.host},
                     {"geometry_fingerprint", info.geometry_fingerprint},
                     {"planes", manifest.planes},
                     {"command", manifest.command},
                     {"fingerprint", manifest.fingerprint}};
    if (!info.denoiser.empty())
        document["denoiser"] = info.denoiser;
    if (info.accumulated_frames > 0)
        document["accumulated_frames"] = info.accumulated_frames;
    if (info.window_columns > 0)
        document["window_columns"] = info.window_columns;
    if (info.patches)
        document["patches"] = patches_to_json(*info.patches);
    if (manifest.single_part)
        document["single_part"] = *manifest.single_part;
    return document;
}

Manifest from_json(const json& document, const std::string& where) {
    const Section in(document, where);
    if (in.text("format") != format_name)
        in.refuse("format", std::string("\"") + format_name + "\"");
    if (in.whole<int>("version", 0, 1 << 20) != format_version)
        in.refuse("version", std::to_string(format_version));
    Manifest manifest;
    FrameInfo& info = manifest.shared;
    const Section first = in.section("first_frame");
    info.camera = camera_from_json(in.section("camera"));
    info.index = first.whole<std::int64_t>("index", 0, max_frame_index);
    info.time_s = first.number("time_s", -max_time_s, max_time_s);
    info.camera_pose = pose_from_json(first.section("camera_pose"));
    info.head = pose_from_json(first.section("head"));
    info.frames_per_second = in.number("frames_per_second", 1e-6, 1e6);
    info.eye = static_cast<Eye>(in.choice("eye", eye_names));
    info.ipd_m = in.number("ipd_m", 0, max_ipd_m);
    if (in.section("camera").text("kind") == "ods" && !make_ods(info))
        in.refuse(info.ipd_m > 0 ? "eye" : "ipd_m", "with camera ods, left or right eyes that are apart");
    info.lock = static_cast<AxisLock>(in.choice("lock", axis_lock_names));
    info.head_radius_m = in.number("lean_m", 0, max_head_box_radius_m);
    info.exposure = in.number("exposure", std::numeric_limits<double>::min(), std::numeric_limits<double>::max());
    info.seed = in.whole<std::uint64_t>("seed", 0, std::numeric_limits<std::uint64_t>::max());
    info.samples_per_pixel = in.whole<std::uint32_t>("samples_per_pixel", 0, 0xffffffffu);
    info.scene = in.text("scene");
    info.host = in.text("host");
    if (document.contains("geometry_fingerprint"))  // earlier sequences have none
        info.geometry_fingerprint = in.text("geometry_fingerprint");
    if (document.contains("denoiser"))
        info.denoiser = in.text("denoiser");
    if (document.contains("accumulated_frames"))
        info.accumulated_frames = in.whole<std::uint32_t>("accumulated_frames", 0, 0xffffffffu);
    if (document.contains("window_columns"))
        info.window_columns = window_columns_from_json(in, info.camera);
    if (document.contains("patches"))
        info.patches = patches_from_json(in.section("patches"), info.camera);
    manifest.planes = in.texts("planes", "a list of plane names");
    manifest.command = in.text("command");
    manifest.fingerprint = in.text("fingerprint");
    if (document.contains("single_part"))  // earlier sequences do not say
        manifest.single_part = in.truth("single_part");
    return manifest;
}

std::string read_text(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (error)
        throw InputError(expected_found(file.string(), "a manifest", error.message()));
    if (bytes > max_manifest_bytes)
        throw InputError(
            expected_found(file.string(), "a manifest of at most 1 MiB", std::to_string(bytes) + " bytes"));
    std::ifstream in(file, std::ios::binary);
    std::string text(static_cast<std::size_t>(bytes), '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!in)
        throw InputError(expected_found(file.string(), "a manifest", "an unreadable file"));
    return text;
}

struct Setting {
    std::string in_full;  // with its name
    std::string value;
};

/// Where a window is differs from frame to frame, so it is taken as if it were straight ahead.
json shared_camera_to_json(const FrameInfo& info) {
    if (info.window_columns == 0)
        return camera_to_json(info.camera);
    json camera = camera_to_json(window_shape(window_grid_of(info)));
    camera["window_columns"] = info.window_columns;
    return camera;
}

/// In an order that tells the plainest difference first.
std::vector<Setting> settings_of(const FrameInfo& info) {
    const std::string size = size_text(width_of(info.camera), height_of(info.camera));
    // Frames that are accumulated may each have their own number.
    const std::string samples = info.accumulated_frames > 0
                                    ? "accumulated over " + std::to_string(info.accumulated_frames) + " frames"
                                    : std::to_string(info.samples_per_pixel);
    const std::string seed = std::to_string(info.seed);
    const std::string camera = shared_camera_to_json(info).dump(), host = "\"" + info.host + "\"";
    const std::string patches = info.patches ? patches_to_json(*info.patches).dump() : "none";
    return {{size + " pixels", size}, {"camera " + camera, camera}, {"spp " + samples, samples},
            {"seed " + seed, seed},   {"host " + host, host},       {"patches " + patches, patches}};
}

constexpr std::string_view prefix = "frame.";

/// The index in "frame.NNNN.EXT", if the name is exactly what frame_file_name would write.
std::optional<std::int64_t> frame_index(const std::string& name, const std::string& extension) {
    if (!name.starts_with(prefix) || !name.ends_with("." + extension))
        return std::nullopt;
    std::int64_t index = -1;
    std::from_chars(name.data() + prefix.size(), name.data() + name.size(), index);
    if (index < 0 || index > max_frame_index || frame_file_name(index, extension) != name)
        return std::nullopt;
    return index;
}

}  // namespace

Manifest read_manifest(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "manifest.json";
    const std::string text = read_text(file);
    json document;
    try {
        document = json::parse(text, [&](int depth, json::parse_event_t, const json&) {
            if (depth > nesting_limit)
                throw InputError(expected_found(
                    file.string(), "at most " + std::to_string(nesting_limit) + " levels of nesting", "more"));
            return true;
        });
    } catch (const json::parse_error& error) {
        throw InputError(
            expected_found(file.string() + ": byte " + std::to_string(error.byte), "JSON", "a syntax error"));
    } catch (const json::exception& error) {
        throw InputError(expected_found(file.string(), "JSON", error.what()));
    }
    return from_json(document, file.string());
}

void write_manifest(const std::filesystem::path& folder, const Manifest& manifest) {
    write_file_atomically(folder / "manifest.json", json_text(to_json(manifest), 4) + "\n");
}

OneRender::OneRender(const std::filesystem::path& folder) {
    const std::filesystem::path manifest = folder / "manifest.json";
    if (!std::filesystem::exists(manifest))
        return;
    expected_ = read_manifest(folder).shared;
    as_in_ = manifest.string();
}

void OneRender::require(const std::filesystem::path& file, const FrameInfo& info) {
    if (!expected_)
        expected_ = info;
    const std::vector<Setting> expected = settings_of(*expected_), found = settings_of(info);
    for (std::size_t i = 0; i < expected.size(); ++i)
        if (expected[i].value != found[i].value)
            throw InputError(expected_found(file.string(), expected[i].in_full + " as in " + as_in_, found[i].value));
}

std::string frame_file_name(std::int64_t index, const std::string& extension) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%04lld", static_cast<long long>(index));
    return std::string(prefix) + digits + "." + extension;
}

void number_as_named(FrameInfo& info, std::int64_t index) {
    info.time_s += double(index - info.index) / info.frames_per_second;
    info.index = index;
}

std::vector<std::int64_t> list_frames(const std::filesystem::path& folder, const std::string& extension) {
    std::error_code error;
    std::filesystem::directory_iterator entries(folder, error);
    if (error)
        throw InputError(expected_found(folder.string(), "a folder of frames", error.message()));
    std::vector<std::int64_t> indices;
    for (const auto& entry : entries)
        if (const auto index = frame_index(entry.path().filename().string(), extension))
            indices.push_back(*index);
    std::sort(indices.begin(), indices.end());
    return indices;
}

bool holds_frames(const std::filesystem::path& folder) {
    return std::filesystem::is_directory(folder) && !list_frames(folder).empty();
}

}  // namespace equistream
