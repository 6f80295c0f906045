#include "settings.h"

#include <equistream/aov_groups.h>
#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/frame_part.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <equistream/window.h>

#include <cstring>

namespace equistream {
namespace {

constexpr std::uint32_t max_samples = 1u << 20;
constexpr std::uint32_t max_threads = 4096;
constexpr std::uint32_t max_accumulated_frames = 1000;
constexpr std::uint32_t max_names = 1u << 24;
constexpr std::size_t longest_name = 65536;

/// A C host may store any int in an enum; read it as one.
template <typename Enum>
int stored_value(const Enum& value) {
    static_assert(sizeof(Enum) == sizeof(int));
    int number = 0;
    std::memcpy(&number, &value, sizeof number);
    return number;
}

void require(bool right, const char* field, const std::string& expected, const std::string& found) {
    if (!right)
        throw InputError(expected_found(field, expected, found));
}

void require(const std::optional<Mismatch>& mismatch, const std::string& field) {
    if (mismatch)
        throw InputError(expected_found(field, mismatch->expected, mismatch->found));
}

double checked_number(const char* field, double value, double min, double max) {
    require(range_mismatch(value, min, max), field);
    return value;
}

std::string checked_text(const char* field, const char* text, std::size_t longest) {
    const std::string value = text == nullptr ? "" : text;
    require(value.size() <= longest, field, "at most " + std::to_string(longest) + " bytes",
            std::to_string(value.size()));
    return value;
}

LongitudeLatitudeRange checked_ranges(const es_sequence_settings& s) {
    LongitudeLatitudeRange range;
    if (s.longitude_min != 0 || s.longitude_max != 0) {
        range.longitude_min = s.longitude_min;
        range.longitude_max = s.longitude_max;
    }
    if (s.latitude_min != 0 || s.latitude_max != 0) {
        range.latitude_min = s.latitude_min;
        range.latitude_max = s.latitude_max;
    }
    require(longitudes_mismatch(range.longitude_min, range.longitude_max), "longitude_min, longitude_max");
    require(latitudes_mismatch(range.latitude_min, range.latitude_max), "latitude_min, latitude_max");
    return range;
}

EquirectCamera checked_window_camera(const es_sequence_settings& s) {
    require(s.window_columns >= window_block_px && s.window_columns <= max_image_side, "window_columns",
            "0, or 16 to " + std::to_string(max_image_side), std::to_string(s.window_columns));
    for (const double* limit : {&s.longitude_min, &s.longitude_max, &s.latitude_min, &s.latitude_max})
        require(*limit == 0, "longitude_min to latitude_max", "0 in a sequence of windows", in_words(*limit));
    require(stored_value(s.layer) == ES_LAYER_FIRST && s.patch_side == 0, "window_columns",
            "0 in a hidden layer and in an atlas of patches", std::to_string(s.window_columns));
    const auto columns = static_cast<int>(s.window_columns);
    const WindowGrid grid{columns, columns / 2, s.width, s.height};
    if (const auto problem = window_grid_problem(grid))
        throw InputError("es_sequence_settings: " + *problem);
    return window_shape(grid);
}

EquirectCamera checked_ods(const es_sequence_settings& s) {
    const int eye = stored_value(s.eye);
    require(eye == ES_EYE_LEFT || eye == ES_EYE_RIGHT, "eye", "ES_EYE_LEFT or ES_EYE_RIGHT with ES_ODS",
            std::to_string(eye));
    require(stored_value(s.layer) == ES_LAYER_FIRST && s.patch_side == 0 && s.accumulate_frames == 0, "camera",
            "no ES_ODS in a hidden layer, in an atlas of patches or where frames are accumulated", "ES_ODS");
    const double ipd_m = checked_number("ipd_m", s.ipd_m, 0, max_ipd_m);
    return {s.width, s.height, checked_ranges(s), ods_side_m(static_cast<Eye>(eye), ipd_m)};
}

Camera checked_camera(const es_sequence_settings& s) {
    const std::string sides = "1 to " + std::to_string(max_image_side);
    require(s.width >= 1 && s.width <= max_image_side, "width", sides, std::to_string(s.width));
    require(s.height >= 1 && s.height <= max_image_side, "height", sides, std::to_string(s.height));
    require(std::int64_t{s.width} * s.height <= max_image_pixels, "width x height",
            "at most " + std::to_string(max_image_pixels) + " pixels", size_text(s.width, s.height));
    const int kind = stored_value(s.camera);
    require(kind == ES_EQUIRECT || s.window_columns == 0, "window_columns", "0 with a camera that is not ES_EQUIRECT",
            std::to_string(s.window_columns));
    if (s.window_columns != 0)
        return checked_window_camera(s);
    if (kind == ES_EQUIRECT)
        return EquirectCamera{s.width, s.height, checked_ranges(s)};
    if (kind == ES_ODS)
        return checked_ods(s);
    require(kind == ES_PERSPECTIVE, "camera", "ES_EQUIRECT, ES_PERSPECTIVE or ES_ODS", std::to_string(kind));
    require(fov_mismatch(s.fov_x_rad), "fov_x_rad");
    return PerspectiveCamera{s.width, s.height, s.fov_x_rad};
}

/// The atlas that all frames share, with its slots unused.
std::optional<PatchAtlas> checked_atlas(const es_sequence_settings& s, const SequenceSettings& of) {
    if (s.patch_side == 0)
        return std::nullopt;
    const auto* sphere = std::get_if<EquirectCamera>(&of.manifest.shared.camera);
    require(sphere != nullptr, "patch_side", "0 with a camera that is not ES_EQUIRECT", std::to_string(s.patch_side));
    require(stored_value(s.layer) == ES_LAYER_FIRST, "patch_side", "0 in a hidden layer", std::to_string(s.patch_side));
    require(s.patch_offset_count >= 1 && s.patch_offset_count <= std::uint32_t{max_patch_offsets} &&
                s.patch_offsets_m != nullptr,
            "patch_offset_count", "1 to " + std::to_string(max_patch_offsets) + " and patch_offsets_m",
            std::to_string(s.patch_offset_count));
    require(s.patch_columns >= 1 && s.patch_rows >= 1 && s.patch_columns <= max_patch_slots &&
                s.patch_rows <= max_patch_slots / s.patch_columns,
            "patch_columns, patch_rows", "1 to " + std::to_string(max_patch_slots) + " slots",
            size_text(s.patch_columns, s.patch_rows));
    for (const std::string& plane : of.manifest.planes)
        require(plane.find("backward") == std::string::npos && plane.find("forward") == std::string::npos, "aovs",
                "no motion in an atlas of patches", plane);
    PatchAtlas atlas;
    atlas.sphere_width = sphere->width;
    atlas.sphere_height = sphere->height;
    atlas.range = sphere->range;
    atlas.block_side = s.patch_side;
    atlas.columns = s.patch_columns;
    atlas.rows = s.patch_rows;
    for (std::uint32_t i = 0; i < s.patch_offset_count; ++i)
        atlas.offsets_m.emplace_back(s.patch_offsets_m[3 * i], s.patch_offsets_m[3 * i + 1],
                                     s.patch_offsets_m[3 * i + 2]);
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("es_sequence_settings: patches: " + *problem);
    return atlas;
}

std::vector<PatchAtlas::Slot> checked_slots(const es_frame_settings& s) {
    require(s.patch_count == 0 || s.patches != nullptr, "patches", "a pointer", "NULL");
    require(s.patch_count <= std::size_t{max_patch_slots}, "patch_count", "at most " + std::to_string(max_patch_slots),
            std::to_string(s.patch_count));
    std::vector<PatchAtlas::Slot> slots(s.patch_count);
    for (std::size_t i = 0; i < s.patch_count; ++i) {
        const es_patch& p = s.patches[i];
        if (p.used == 0)
            continue;
        const std::string where = "patches[" + std::to_string(i) + "]";
        require(p.offset_index < std::uint32_t{max_patch_offsets} && p.block_x < std::uint32_t{max_image_side} &&
                    p.block_y < std::uint32_t{max_image_side},
                where.c_str(), "a block of one of the sequence's offsets",
                std::to_string(p.offset_index) + ": " + std::to_string(p.block_x) + ", " + std::to_string(p.block_y));
        slots[i] = {static_cast<std::uint8_t>(p.offset_index), static_cast<std::uint16_t>(p.block_x),
                    static_cast<std::uint16_t>(p.block_y), true};
    }
    return slots;
}

Pose checked_pose(const char* field, const es_pose& pose) {
    const double* p = pose.position_m;
    const double* q = pose.orientation_wxyz;
    const glm::dvec3 position_m(p[0], p[1], p[2]);
    const glm::dquat orientation(q[0], q[1], q[2], q[3]);
    require(position_mismatch(position_m), std::string(field) + ".position_m");
    require(orientation_mismatch(orientation), std::string(field) + ".orientation_wxyz");
    return {position_m, orientation / glm::length(orientation)};
}

}  // namespace

std::shared_ptr<Denoiser> checked_denoiser(const es_sequence_settings* settings) {
    const es_sequence_settings s = whole_struct(settings, "es_sequence_settings", sequence_settings_sizes);
    const int quality = stored_value(s.denoise);
    require(quality >= ES_DENOISE_OFF && quality <= ES_DENOISE_HIGH, "denoise", "ES_DENOISE_OFF to ES_DENOISE_HIGH",
            std::to_string(quality));
    require(s.denoise_threads <= max_threads, "denoise_threads", "at most " + std::to_string(max_threads),
            std::to_string(s.denoise_threads));
    if (quality == ES_DENOISE_OFF)
        return nullptr;
    return std::make_shared<Denoiser>(static_cast<DenoiseQuality>(quality), s.denoise_threads);
}

SequenceSettings checked_settings(const es_sequence_settings* settings, const Denoiser* denoiser) {
    const es_sequence_settings s = whole_struct(settings, "es_sequence_settings", sequence_settings_sizes);
    require(s.abi_version == ES_ABI_VERSION, "abi_version", std::to_string(ES_ABI_VERSION),
            std::to_string(s.abi_version));
    require(s.spp >= 1 && s.spp <= max_samples, "spp", "1 to " + std::to_string(max_samples), std::to_string(s.spp));
    const int eye = stored_value(s.eye);
    require(eye >= ES_EYE_CENTRE && eye <= ES_EYE_RIGHT, "eye", "ES_EYE_CENTRE, ES_EYE_LEFT or ES_EYE_RIGHT",
            std::to_string(eye));
    const int lock = stored_value(s.lock);
    require(lock == ES_LOCK_WORLD || lock == ES_LOCK_PATH, "lock", "ES_LOCK_WORLD or ES_LOCK_PATH",
            std::to_string(lock));
    require(s.output_dir != nullptr && *s.output_dir != '\0', "output_dir", "a folder",
            s.output_dir == nullptr ? "NULL" : "an empty name");
    require(s.aovs != nullptr, "aovs", "groups such as \"depth,motion\", \"all\" or \"none\"", "NULL");

    SequenceSettings checked;
    checked.folder = s.output_dir;
    checked.overwrite = s.overwrite != 0;
    checked.single_part = s.single_part != 0;
    checked.manifest.single_part = checked.single_part;
    checked.manifest.planes = parse_aov_groups(s.aovs);
    checked.manifest.command = checked_text("command", s.command, 65536);
    FrameInfo& info = checked.manifest.shared;
    info.camera = checked_camera(s);
    info.window_columns = static_cast<int>(s.window_columns);
    info.eye = static_cast<Eye>(eye);
    info.lock = static_cast<AxisLock>(lock);
    info.ipd_m = checked_number("ipd_m", s.ipd_m, 0, max_ipd_m);
    info.head_radius_m = checked_number("head_radius_m", s.head_radius_m, 0, max_head_box_radius_m);
    info.frames_per_second = checked_number("frames_per_second", s.frames_per_second, 0.001, 1000);
    info.exposure = checked_number("exposure", s.exposure, 1e-12, 1e12);
    info.seed = s.seed;
    info.samples_per_pixel = s.spp;
    info.scene = checked_text("scene_name", s.scene_name, max_name_bytes);
    info.host = checked_text("host_name", s.host_name, max_name_bytes);
    info.geometry_fingerprint = checked_text("geometry_fingerprint", s.geometry_fingerprint, max_name_bytes);
    info.patches = checked_atlas(s, checked);
    if (denoiser != nullptr)
        info.denoiser = denoiser->description();
    require(denoiser != nullptr || std::ranges::find(checked.manifest.planes, "raw") == checked.manifest.planes.end(),
            "aovs", "raw only where colour is denoised", "raw");
    const bool hidden_layer = checked_tile_settings(settings).hidden_layer;
    require(s.accumulate_frames <= max_accumulated_frames, "accumulate_frames",
            "at most " + std::to_string(max_accumulated_frames), std::to_string(s.accumulate_frames));
    require(s.accumulate_frames == 0 || (!hidden_layer && !info.patches), "accumulate_frames",
            "0 in a hidden layer and in an atlas of patches", std::to_string(s.accumulate_frames));
    info.accumulated_frames = s.accumulate_frames;
    for (const char* plane : {"samples", "variance"})
        require(s.accumulate_frames > 0 ||
                    std::ranges::find(checked.manifest.planes, plane) == checked.manifest.planes.end(),
                "aovs", std::string(plane) + " only where frames are accumulated", plane);
    require((!hidden_layer && !info.patches) ||
                std::ranges::find(checked.manifest.planes, "reference") == checked.manifest.planes.end(),
            "aovs", "no reference in a hidden layer or an atlas of patches", "reference");
    require((!hidden_layer && !info.patches && s.accumulate_frames == 0) ||
                std::ranges::find(checked.manifest.planes, "crypto_object") == checked.manifest.planes.end(),
            "aovs", "no cryptomatte in a hidden layer or an atlas of patches, or where frames are accumulated",
            "cryptomatte");
    checked.texts = cryptomatte_attributes(checked.manifest.planes, checked_names(settings));
    require(s.samples_by_angle == 0 ||
                (s.accumulate_frames == 0 && !info.patches && std::holds_alternative<EquirectCamera>(info.camera)),
            "samples_by_angle", "0 in flat views, in an atlas of patches and where frames are accumulated",
            std::to_string(s.samples_by_angle));
    require(s.part_count <= max_frame_parts, "part_count", "at most " + std::to_string(max_frame_parts),
            std::to_string(s.part_count));
    require(s.part <= s.part_count, "part", "at most part_count, " + std::to_string(s.part_count),
            std::to_string(s.part));
    require(s.part_count == 0 || (s.accumulate_frames == 0 && !info.patches), "part_count",
            "0 in an atlas of patches and where frames are accumulated", std::to_string(s.part_count));
    checked.part = {s.part, s.part_count};
    checked.tile_side = checked_tile_settings(settings).tile_side;
    std::string tiles = hidden_layer ? " hidden layer" : "";
    if (s.samples_by_angle != 0)
        tiles += " samples by angle";
    if (s.samples_by_angle != 0 || s.accumulate_frames > 0)  // samples are given out by tiles
        tiles += " tiles of " + std::to_string(checked.tile_side);
    checked.manifest.fingerprint =
        sequence_fingerprint(checked.manifest, checked_text("fingerprint", s.fingerprint, 65536) + tiles);
    return checked;
}

CryptomatteNames checked_names(const es_sequence_settings* settings) {
    const es_sequence_settings s = whole_struct(settings, "es_sequence_settings", sequence_settings_sizes);
    const auto read = [](const char* field, const char* const* names, std::uint32_t count) {
        std::vector<std::string> texts;
        require(names != nullptr || count == 0, field, "a pointer", "NULL");
        require(count <= max_names, field, "at most " + std::to_string(max_names), std::to_string(count));
        for (std::uint32_t i = 0; i < count; ++i) {
            texts.push_back(checked_text(field, names[i], longest_name));
            require(is_utf8(texts.back()), field, "UTF-8", "\"" + as_json_holds(texts.back()) + "\"");
        }
        return texts;
    };
    return {read("object_names", s.object_names, s.object_name_count),
            read("material_names", s.material_names, s.material_name_count)};
}

TileSettings checked_tile_settings(const es_sequence_settings* settings) {
    const es_sequence_settings s = whole_struct(settings, "es_sequence_settings", sequence_settings_sizes);
    const int layer = stored_value(s.layer);
    require(layer == ES_LAYER_FIRST || layer == ES_LAYER_HIDDEN, "layer", "ES_LAYER_FIRST or ES_LAYER_HIDDEN",
            std::to_string(layer));
    require(s.tile_side >= 0 && s.tile_side <= max_image_side, "tile_side", "0 to " + std::to_string(max_image_side),
            std::to_string(s.tile_side));
    return {layer == ES_LAYER_HIDDEN, s.tile_side == 0 ? default_tile_side : s.tile_side, s.samples_by_angle != 0};
}

FrameSettings checked_settings(const es_frame_settings* settings) {
    const es_frame_settings s = whole_struct(settings, "es_frame_settings", frame_settings_sizes);
    require(s.index >= 0 && s.index <= max_frame_index, "index", "0 to " + std::to_string(max_frame_index),
            std::to_string(s.index));
    require(s.spp <= max_samples, "spp", "at most " + std::to_string(max_samples), std::to_string(s.spp));
    require(s.previous_frames <= std::uint32_t{max_frame_index}, "previous_frames",
            "at most " + std::to_string(max_frame_index), std::to_string(s.previous_frames));
    return {s.index,
            checked_number("time_s", s.time_s, -max_time_s, max_time_s),
            checked_pose("head_previous", s.head_previous),
            checked_pose("head", s.head),
            checked_pose("head_next", s.head_next),
            checked_slots(s),
            s.spp,
            std::max(s.previous_frames, std::uint32_t{1}),
            {s.window_x, s.window_y},
            s.window};
}

namespace {

/// The window's frame of this index: as it was begun, or as it is kept.
std::shared_ptr<const WindowFrame> window_frame(const es_sequence& sequence, std::int64_t index) {
    if (sequence.window_frame && sequence.window_frame->info.index == index)
        return sequence.window_frame;
    require(sequence.shared->keeps_frame(index), "window",
            "a sequence that has begun frame " + std::to_string(index) + " or keeps it",
            sequence.window_frame ? "frame " + std::to_string(sequence.window_frame->info.index) : "no frame");
    auto kept = std::make_shared<WindowFrame>();
    kept->info = read_exr_info(sequence.shared->frame_file(index));
    kept->is_written = true;
    return kept;
}

bool same_pose(const Pose& a, const Pose& b) {
    constexpr double rounding = 1e-9;
    return glm::distance(a.position_m, b.position_m) < rounding &&
           std::abs(glm::dot(a.orientation, b.orientation)) > 1 - rounding;
}

}  // namespace

WindowInBase checked_window(const es_sequence& sequence, const FrameInfo& base, bool is_hidden_layer) {
    const FrameInfo& windows = sequence.shared->manifest().shared;
    require(windows.window_columns > 0, "window", "a sequence of windows", "one of whole pictures");
    const auto* sphere = std::get_if<EquirectCamera>(&base.camera);
    require(sphere != nullptr && is_centred_full_sphere(sphere->range) && base.window_columns == 0 && !base.patches &&
                !is_hidden_layer,
            "window", "NULL but in whole spheres of the first surfaces", "a sequence of windows");
    const WindowGrid grid = window_grid_of(windows);
    require(grid.columns > sphere->width && grid.rows > sphere->height, "window",
            "one of a denser sphere than " + size_text(sphere->width, sphere->height),
            size_text(grid.columns, grid.rows));
    const auto require_same = [](bool same, const char* what) {
        require(same, "window", std::string("the base's ") + what, "another one");
    };
    require_same(windows.eye == base.eye, "eye");
    require_same(windows.lock == base.lock, "lock");
    require_same(windows.ipd_m == base.ipd_m, "ipd_m");
    std::shared_ptr<const WindowFrame> frame = window_frame(sequence, base.index);
    require_same(same_pose(frame->info.head, base.head) && same_pose(frame->info.camera_pose, base.camera_pose),
                 "head");
    const auto* camera = std::get_if<EquirectCamera>(&frame->info.camera);
    require_same(camera != nullptr && window_grid_of(frame->info) == grid, "size");
    const std::optional<WindowPlace> place = window_place(grid, camera->range);
    require_same(place.has_value(), "sphere");
    return {sequence.shared, std::move(frame), WindowCover(grid, *place, sphere->width, sphere->height)};
}

void leave_to_window(const WindowCover& cover, const FrameInfo& base, int tile_side,
                     std::vector<std::uint32_t>& samples) {
    const int width = picture_width(base), height = picture_height(base);
    auto tile = samples.begin();
    for (int y = 0; y < height; y += tile_side)
        for (int x = 0; x < width; x += tile_side, ++tile)
            if (cover.covers(x, y, std::min(tile_side, width - x), std::min(tile_side, height - y)))
                *tile = 0;
}

FloatImage window_colour(const WindowInBase& window) {
    const FrameInfo& expected = window.frame->info;
    require(window.frame->is_written, "window", "its frame ended before the base's", "one that is not written");
    const std::filesystem::path file = window.sequence->frame_file(expected.index);
    Frame written = read_exr(file, {"colour"});
    const FrameInfo& found = written.info;
    const auto place = [](const FrameInfo& info) {
        return window_place(window_grid_of(info), std::get<EquirectCamera>(info.camera).range);
    };
    if (found.window_columns == 0 || window_grid_of(found) != window_grid_of(expected) ||
        place(found) != place(expected))
        throw InputError(expected_found(file.string(), "the window as it was when the base began", "another one"));
    return std::move(written.planes.at("colour"));
}

}  // namespace equistream
