/// EXR files: frames of ours.
#include "target.h"

#include <equistream/sequence.h>
#include <tests/unit/plugin/export/frame_fixture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace equistream::fuzz {

// Headers: where the values of their attributes are.

namespace {

struct Attribute {
    std::size_t name = 0, type = 0, size = 0, value = 0;  ///< where each begins
    std::size_t bytes = 0;                                ///< of the value
};

std::uint32_t number_at(Bytes bytes, std::size_t at) {
    std::uint32_t number = 0;
    std::memcpy(&number, &bytes[at], sizeof number);
    return number;
}

/// Of all headers, as far as they can be told.
std::vector<Attribute> attributes_of(Bytes bytes) {
    std::vector<Attribute> found;
    const auto behind_text = [&](std::size_t at) {
        return std::size_t(std::find(bytes.begin() + std::ptrdiff_t(std::min(at, bytes.size())), bytes.end(), 0) -
                           bytes.begin()) +
               1;
    };
    std::size_t at = 8;
    for (bool ended = false; at < bytes.size();) {
        if (bytes[at] == 0) {  // the end of a header; two of them: of all
            if (std::exchange(ended, true))
                break;
            ++at;
            continue;
        }
        ended = false;
        Attribute one{at, behind_text(at), 0, 0, 0};
        one.size = behind_text(one.type);
        one.value = one.size + 4;
        if (one.value > bytes.size())
            break;
        one.bytes = number_at(bytes, one.size);
        if (one.bytes > bytes.size() - one.value)
            break;
        at = one.value + one.bytes;
        found.push_back(one);
    }
    return found;
}

void set_text(const Attribute& one, std::string_view text, std::vector<std::uint8_t>& bytes) {
    const auto value = bytes.begin() + std::ptrdiff_t(one.value);
    bytes.erase(value, value + std::ptrdiff_t(one.bytes));
    bytes.insert(bytes.begin() + std::ptrdiff_t(one.value), text.begin(), text.end());
    const auto size = std::uint32_t(text.size());
    std::memcpy(&bytes[one.size], &size, sizeof size);
}

}  // namespace

/// Pixels are no longer where the file says once a text has another length; attributes are read before.
void damage_attributes(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    static const std::string endless(300, 'x');
    const std::array<std::string_view, 20> texts = {
        "",         "-1",  "0",     "7",     "99999999999999999999", "centre", "path", "perspective",
        "equirect", "1x1", "64x32", "0 0 0", "0 0 0.1,0 0",          "0 0 9",  "-,-",  "0:0:0,-",
        "0:9:9,-",  "7:0", "\xff",  endless};
    const std::vector<Attribute> all = attributes_of(bytes);
    if (all.empty())
        return;
    const Attribute& one = all[random() % all.size()];
    const std::string_view type(reinterpret_cast<const char*>(&bytes[one.type]));
    switch (random() % 8) {
    case 0:
        bytes[one.name] = '_';  // as if it were not there
        break;
    case 1:
        bytes[one.type] = '_';
        break;
    case 2:
        if (one.bytes > 0)
            bytes[one.value + random() % one.bytes] = std::uint8_t(" -,:.0159ax"[random() % 11]);
        break;
    default:
        if (type == "string" && random() % 2 == 0)
            set_text(one, texts[random() % texts.size()], bytes);
        else
            damage_behind(Bytes(bytes).subspan(one.size, 4), one.bytes,
                          std::span(bytes).subspan(one.size, 4 + one.bytes), random);
    }
}

// A frame, ours or anybody's.

namespace {

void take_frame(Bytes bytes) {
    const std::filesystem::path file = scratch_file("frame.exr", bytes);
    const Frame frame = read_exr(file);
    const PatchAtlas* const atlas = frame.info.patches ? &*frame.info.patches : nullptr;
    const int width = atlas ? atlas->width() : width_of(frame.info.camera);
    const int height = atlas ? atlas->height() : height_of(frame.info.camera);
    require(!frame.planes.empty() || !frame.ids.empty(), "there is a plane");
    for (const auto& [name, plane] : frame.planes)
        require(plane.width() == width && plane.height() == height, "planes have the camera's size");
    for (const auto& [name, plane] : frame.ids)
        require(plane.width() == width && plane.height() == height, "planes have the camera's size");
    require_whole_exr(file);
    check_exr_pixels(file);
    // What was accepted can be written and read again.
    write_exr(file, frame);
    const Frame again = read_exr(file);
    require(again.planes.size() == frame.planes.size() && again.ids.size() == frame.ids.size() &&
                again.info.patches.has_value() == frame.info.patches.has_value(),
            "a frame read again has the same planes");
    require(read_exr_info(file).index == frame.info.index, "attributes are the same without the pixels");
    require(read_exr(file, {"colour", "colour"}).planes.size() == 1, "no more is read than what is asked for");
}

std::vector<std::uint8_t> written(const Frame& frame, const ExrWriteOptions& options) {
    const std::filesystem::path file = scratch_file("seed.exr", {});
    write_exr(file, frame, options);
    return bytes_of_file(file);
}

Seeds frame_seeds() {
    Frame colour_only = testing::test_frame(7, 20);
    std::erase_if(colour_only.planes, [](const auto& plane) { return plane.first != "colour"; });
    colour_only.ids.clear();
    Seeds seeds{written(testing::test_frame(12, 18), {}), written(testing::test_frame(5, 3), {.single_part = true}),
                written(colour_only, {.left_out_samples = 3})};
    const auto add = [&](int width, int height, const auto& change) {
        Frame frame = testing::test_frame(width, height);
        std::erase_if(frame.planes, [](const auto& plane) { return plane.first != "colour"; });
        frame.ids.clear();
        change(frame.info);
        seeds.push_back(written(frame, {}));
    };
    add(16, 12, [](FrameInfo& info) {
        info.camera = PerspectiveCamera{16, 12, 1.5};
        info.denoiser = "mean";
        info.accumulated_frames = 8;
        info.frames_per_second = 12.3456;
    });
    add(32, 16, [](FrameInfo& info) {
        info.window_columns = 256;
        info.camera = window_camera({256, 128, 32, 16}, {48, 64});
    });
    add(32, 16, [](FrameInfo& info) {
        info.camera = EquirectCamera{64, 32, {}};
        info.patches = PatchAtlas{64, 32, 16, {}, {{0.05, 0, 0}, {-0.05, 0, 0}}, 2, 1, {{1, 3, 1, true}, {}}};
    });
    return seeds;
}

}  // namespace

const Target exr_target{"exr", take_frame, frame_seeds, 1000, damage_attributes};

}  // namespace equistream::fuzz
