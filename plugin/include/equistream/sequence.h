#pragma once
/// EXR frames and sequences on disk. A sequence is a folder with frame.NNNN.exr files and a manifest.json.
/// Files appear whole or not at all: they are written under another name, synced, then renamed. Readers treat every
/// file as hostile: sizes are checked against image.h's limits before anything is allocated. Functions throw WorkError
/// (I/O) or InputError (unexpected content), naming the file.
#include <equistream/aov.h>
#include <equistream/frame.h>
#include <equistream/stream.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

struct ExrWriteOptions {
    bool single_part = false;  ///< one part, with depth also as plain channel "Z", for readers of first parts alone
    std::int64_t left_out_samples = 0;          ///< colour samples that were not finite; above 0: recorded in the file
    std::function<void()> before_it_appears{};  ///< called when the file is complete and synced, before its renaming
    /// Names and texts of further string attributes. Names have at most 31 bytes.
    std::vector<std::pair<std::string, std::string>> texts{};
};

/// Checks the samples of a plane: distances, virtual ones too, are at least 0 or +inf; radiance may be anything,
/// because write_exr clamps it; all others are finite. Throws InputError naming the plane, the pixel and the value.
void require_plane_values(const AovInfo& aov, ImageView<const float> plane);

/// Writes `frame` to `file` atomically. Samples of half channels are clamped to +-65,504, and NaN becomes 0. Returns
/// the number of pixels with a channel of colour that was not finite.
std::int64_t write_exr(const std::filesystem::path& file, const Frame& frame, const ExrWriteOptions& options = {});

/// Reads the named planes ("colour", "depth", ...); an empty list reads all planes of the file. Accepts scan lines with
/// NONE, RLE, ZIPS or ZIP compression only. A foreign file, without our attributes, gets a default FrameInfo with its
/// size, and A = 1 if it has no alpha.
Frame read_exr(const std::filesystem::path& file, const std::vector<std::string>& planes = {});

/// Reads attributes only. Throws InputError for a foreign file.
FrameInfo read_exr_info(const std::filesystem::path& file);

/// Throws InputError for a file that was cut or never finished: its table must have an offset for each chunk of rows,
/// within the file. Reads the header and a few bytes of every chunk, no pixels.
void require_whole_exr(const std::filesystem::path& file);

/// Decodes every channel of every part without keeping them. Throws InputError if one is damaged. Takes the memory of a
/// few chunks, however large the picture is.
void check_exr_pixels(const std::filesystem::path& file);

/// Gives a renamed or foreign frame the index of its file's name. Its time moves by the difference of the indices over
/// info.frames_per_second.
void number_as_named(FrameInfo& info, std::int64_t index);

/// "frame.0007.exr"
std::string frame_file_name(std::int64_t index, const std::string& extension = "exr");

/// Writes `text` under another name, syncs, and renames it to `file`: the file appears whole or not at all.
void write_file_atomically(const std::filesystem::path& file, const std::string& text);

/// Removes unfinished files of killed writers from `folder`. Files that another process is writing stay.
void remove_unfinished_files(const std::filesystem::path& folder);

/// Content of a sequence's manifest.json: the settings that all its frames share.
struct Manifest {
    /// Index, time and poses belong to the frame with the lowest index. The camera of windows is window_shape().
    FrameInfo shared;
    std::vector<std::string> planes;    ///< names of the AOV catalogue
    std::string command;                ///< command line, for the record
    std::string fingerprint;            ///< hash of everything that decides the pixels; another one is not resumed
    std::optional<bool> single_part{};  ///< layout of the EXR files; nullopt in old manifests
};

/// Throws InputError for a missing, damaged or unknown manifest.
Manifest read_manifest(const std::filesystem::path& folder);
void write_manifest(const std::filesystem::path& folder, const Manifest& manifest);

/// Checks that the frames of one folder belong to one render: they share camera, seed, host, patches and samples per
/// pixel (accumulated frames: the number of frames). The manifest gives these settings; without one, the first frame
/// that is checked.
class OneRender {
public:
    explicit OneRender(const std::filesystem::path& folder);
    /// Throws InputError naming `file` and the setting that differs in `info`.
    void require(const std::filesystem::path& file, const FrameInfo& info);

private:
    std::optional<FrameInfo> expected_;
    std::string as_in_ = "the frames before it";
};

/// What frames of two folders have in common. Each value includes the ones before it.
enum class Companion {
    scene,  ///< scene, geometry and time
    head,   ///< the head's pose and the interpupillary distance
    light,  ///< exposure and seed
    eye     ///< the eye
};

/// What a frame of this role must have in common with the main frame that it is shown with. In a video of both eyes,
/// both have the role main.
Companion companion_of(TrackRole role);

/// Throws InputError unless `other`, of `folder`, has in common with `main`, of `main_folder`, what `companion` says.
/// The message names `folder`, the frame and the first difference, and ends with `hint`, advice for the user.
void require_companion(Companion companion, const std::filesystem::path& main_folder, const FrameInfo& main,
                       const std::filesystem::path& folder, const FrameInfo& other, const std::string& hint);

/// Indices of the finished frames in the folder, ascending. Throws InputError if it cannot be read.
std::vector<std::int64_t> list_frames(const std::filesystem::path& folder, const std::string& extension = "exr");
/// Whether it is a folder with finished frames in it. Throws as list_frames.
bool holds_frames(const std::filesystem::path& folder);

}  // namespace equistream
