#include "describe.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <openexr.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace equistream {

namespace {

constexpr const char* type_names[] = {"uint", "half", "float"};
constexpr const char* compression_names[] = {"none",  "rle", "zips", "zip",  "piz",
                                             "pxr24", "b44", "b44a", "dwaa", "dwab"};

template <std::size_t N>
const char* name_of(const char* const (&names)[N], int value) {
    return value >= 0 && static_cast<std::size_t>(value) < N ? names[value] : "unknown";
}

/// OpenEXR's reading context, header only.
class Header {
public:
    explicit Header(const std::filesystem::path& file) : file_(file.string()) {
        exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
        initializer.error_handler_fn = [](exr_const_context_t, exr_result_t, const char*) {};
        initializer.max_image_width = initializer.max_image_height = max_image_side;
        check(exr_start_read(&context_, file_.c_str(), &initializer));
    }
    ~Header() { exr_finish(&context_); }
    Header(const Header&) = delete;
    Header& operator=(const Header&) = delete;

    int part_count() const {
        int count = 0;
        check(exr_get_count(context_, &count));
        return count;
    }
    std::string part_name(int part) const {
        const char* name = nullptr;  // a single part need not have one
        return exr_get_name(context_, part, &name) == EXR_ERR_SUCCESS && name ? name : "";
    }
    /// Colour samples that were not finite; 0 where none are noted.
    std::int64_t left_out_samples() const {
        std::int32_t length = 0;
        const char* count = nullptr;
        const bool noted =
            exr_attr_get_string(context_, 0, "equistream:leftOutSamples", &length, &count) == EXR_ERR_SUCCESS;
        return noted && count ? std::strtoll(count, nullptr, 10) : 0;
    }
    std::string compression(int part) const {
        exr_compression_t compression{};
        check(exr_get_compression(context_, part, &compression));
        return name_of(compression_names, compression);
    }
    std::pair<int, int> size(int part) const {
        exr_attr_box2i_t window{};
        check(exr_get_data_window(context_, part, &window));
        return {window.max.x - window.min.x + 1, window.max.y - window.min.y + 1};
    }
    std::vector<exr_attr_chlist_entry_t> channels(int part) const {
        const exr_attr_chlist_t* list = nullptr;
        check(exr_get_channels(context_, part, &list));
        return {list->entries, list->entries + list->num_channels};
    }

private:
    void check(exr_result_t result) const {
        if (result != EXR_ERR_SUCCESS)
            throw InputError(expected_found(file_, "an EXR file", exr_get_default_error_message(result)));
    }

    std::string file_;
    exr_context_t context_ = nullptr;
};

const AovInfo* plane_of_channel(std::string_view channel) {
    for (const AovInfo& aov : aov_catalogue())
        if (std::find(aov.channels.begin(), aov.channels.end(), channel) != aov.channels.end())
            return &aov;
    return nullptr;
}

void add_part(const Header& header, int part, Description& description) {
    const auto [width, height] = header.size(part);
    nlohmann::json channels = nlohmann::json::array();
    description.text += formatted("part %s: %dx%d, %s compression\n", shown(header.part_name(part)).c_str(), width,
                                  height, header.compression(part).c_str());
    for (const exr_attr_chlist_entry_t& channel : header.channels(part)) {
        const std::string name = channel.name.str;
        const char* type = name_of(type_names, channel.pixel_type);
        const AovInfo* plane = plane_of_channel(name);
        const std::string unit = plane && !plane->unit.empty() ? " [" + std::string(plane->unit) + "]" : "";
        description.text += formatted("  %-12s %-5s ", shown(name).c_str(), type) +
                            (plane ? std::string(plane->name) + unit + ": " + std::string(plane->meaning)
                                   : std::string("unknown to equistream")) +
                            "\n";
        channels.push_back({{"name", name},
                            {"type", type},
                            {"plane", plane ? nlohmann::json(plane->name) : nlohmann::json()},
                            {"unit", plane ? nlohmann::json(plane->unit) : nlohmann::json()}});
    }
    description.json["parts"].push_back({{"name", header.part_name(part)},
                                         {"width", width},
                                         {"height", height},
                                         {"compression", header.compression(part)},
                                         {"channels", channels}});
}

}  // namespace

bool is_exr(const std::filesystem::path& file) {
    constexpr unsigned char magic[] = {0x76, 0x2f, 0x31, 0x01};
    char start[4] = {};
    std::ifstream(file, std::ios::binary).read(start, sizeof start);
    return std::equal(std::begin(magic), std::end(magic), start,
                      [](unsigned char a, char b) { return a == static_cast<unsigned char>(b); });
}

Description describe_exr(const std::filesystem::path& file) {
    Description description;
    description.json = {
        {"kind", "exr"}, {"file", file.string()}, {"parts", nlohmann::json::array()}, {"frame", nullptr}};
    const Header header(file);
    description.text = shown(file.string()) + ": EXR image, " +
                       bytes_text(static_cast<double>(std::filesystem::file_size(file))) + "\n";
    for (int part = 0; part < header.part_count(); ++part)
        add_part(header, part, description);
    bool ours = true;
    try {
        const FrameInfo info = read_exr_info(file);
        description.text += formatted("frame %lld at %.4f s, %g frames/s\n  pose       ",
                                      static_cast<long long>(info.index), info.time_s, info.frames_per_second) +
                            pose_text(info.camera_pose) + "\n" + shared_text(info);
        description.json["frame"] = frame_json(info);
        if (const std::int64_t left_out = header.left_out_samples(); left_out > 0) {
            description.text += "  left out   " + std::to_string(left_out) + " samples that were not finite\n";
            description.json["left_out_samples"] = left_out;
        }
    } catch (const InputError& error) {
        description.text += std::string("no equistream frame data: ") + error.what() + "\n";
        ours = false;
    }
    if (ours)
        check_exr_pixels(file);  // a header says nothing of pixels that are cut off or damaged
    return description;
}

}  // namespace equistream
