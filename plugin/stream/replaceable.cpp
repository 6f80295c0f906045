#include <equistream/error.h>
#include <equistream/stream.h>

#include <exception>
#include <filesystem>

namespace equistream {

namespace {

/// A single one of ours may have lost its frame data.
constexpr int pictures_to_judge_by = 4;

/// Without poses there is no frame data, but containers keep the tracks' names.
bool is_stream_of_ours(const std::string& file) {
    try {
        StreamReader reader(file, {.rgb = false, .depth = false, .images = false});
        if (reader.tracks().front().name == track_name(TrackRole::main))
            return true;
        for (int i = 0; i < pictures_to_judge_by; ++i) {
            const std::optional<DecodedPicture> picture = reader.next();
            if (!picture || picture->info)
                return picture.has_value();
        }
    } catch (const std::exception&) {
        // It is no video, or not one that this version reads.
    }
    return false;
}

}  // namespace

void require_replaceable_stream(const std::string& target) {
    std::error_code error;
    if (!is_url(target) && std::filesystem::is_regular_file(target, error) &&
        std::filesystem::file_size(target, error) > 0 && !is_stream_of_ours(target))
        throw InputError(expected_found("--out " + target, "a new name, or an earlier stream of equistream to replace",
                                        "another file; choose another name, or remove that file"));
}

}  // namespace equistream
