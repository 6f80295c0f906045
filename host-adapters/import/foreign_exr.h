#pragma once
/// Any flat EXR file: its channels by name, its size, and the attributes that tell of cameras, colour and views. Files
/// are taken for hostile: sizes are held to image.h's limits and to the file's own length before anything is allocated.
#include <equistream/image.h>
#include <equistream/rec709.h>

#include <glm/glm.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream::files {

struct ForeignChannel {
    std::string name;   ///< as in the file
    std::string part;   ///< the part's name; empty where it has none
    std::string view;   ///< "left", "right", ...; empty where the file knows no views
    std::string plain;  ///< the name without its view, with the part's name before it where it says more
    int part_index = 0;
    bool is_id = false;    ///< stored as unsigned integers
    bool is_half = false;  ///< stored as half floats
};

/// A look at a file's headers before OpenEXR's, which asks for as much memory as an attribute says it has. Throws
/// InputError for headers whose attributes say that they are longer than the file, or that have no end. What they hold
/// is not looked at.
void require_attributes_within(const std::filesystem::path& file, std::uintmax_t file_bytes);

/// Throws InputError naming the file for what is no flat EXR (deep data), too large, or cut.
class ForeignExr {
public:
    explicit ForeignExr(const std::filesystem::path& file);
    ~ForeignExr();
    ForeignExr(ForeignExr&&) noexcept;

    const std::filesystem::path& file() const;
    int width() const;  ///< of the display window, which is what cameras see
    int height() const;
    /// Where all parts have pixels, within the display window: none where width or height is 0.
    struct Rectangle {
        int x = 0, y = 0, width = 0, height = 0;
    };
    Rectangle pixels() const;
    const std::vector<ForeignChannel>& channels() const;
    /// As written, or none.
    std::optional<double> frames_per_second() const;
    std::optional<Chromaticities> chromaticities() const;
    /// Element [i][j] is the file's row i, column j.
    std::optional<glm::dmat4> world_to_camera() const;
    std::optional<glm::dmat4> world_to_ndc() const;
    /// Whether it is a frame of ours, or was before some program changed it.
    bool is_our_own() const;
    /// Whether it is a frame of ours by omnidirectional stereo.
    bool says_ods() const;
    std::string software() const;  ///< what wrote the file, if it says; printable

    /// Decodes these once for all, four bytes a pixel each, for read(): blocks of a file hold all of its channels.
    void decode(const std::vector<ForeignChannel>& channels);
    /// One channel over the display window; `outside` where the file has no pixels. Subsampled channels are refused.
    FloatImage read(const ForeignChannel& channel, float outside) const;
    IdImage read_ids(const ForeignChannel& channel) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The first of a frame's files that says something (`says` gives true, or an optional with a value); else the first.
template <typename Says>
const ForeignExr& first_that(std::span<const ForeignExr> files, const Says& says) {
    const auto found =
        std::ranges::find_if(files, [&](const ForeignExr& file) { return bool(std::invoke(says, file)); });
    return found == files.end() ? files.front() : *found;
}

}  // namespace equistream::files
