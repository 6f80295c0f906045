#pragma once
/// EXR frames and sequences on disk. A sequence is a folder with frame.NNNN.exr files and a manifest.json.
/// Frames appear whole or not at all: written beside their name, synced, then renamed. Readers treat every file as
/// hostile: sizes are checked against image.h's limits before anything is allocated.
/// Functions throw WorkError (I/O) or InputError (not what was expected), naming the file.
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
    bool single_part = false;  ///< one part with plain channel "Z" besides, for readers that know only the first part
    std::int64_t left_out_samples = 0;          ///< colour samples that were not finite; above 0: noted in the file
    std::function<void()> before_it_appears{};  ///< called once the file is whole and safe beside its name
    /// Names and texts of more attributes, of names no longer than 31 bytes.
    std::vector<std::pair<std::string, std::string>> texts{};
};

/// What samples of a plane may be, whoever made them: distances (also virtual ones) are at least 0 and may be +inf,
/// everything else is finite; of radiance nothing is asked, the writer takes care of it. Throws InputError naming the
/// plane, the pixel and the value.
void require_plane_values(const AovInfo& aov, ImageView<const float> plane);

/// Writes `frame` to `file` atomically. Colour is clamped to the half range; NaN becomes 0 and is counted.
/// Returns the number of colour pixels that were not finite.
std::int64_t write_exr(const std::filesystem::path& file, const Frame& frame, const ExrWriteOptions& options = {});

/// Reads the named planes ("colour", "depth", ...); an empty list reads all there are. Scan lines with NONE, RLE, ZIPS
/// or ZIP compression only. A foreign file, without our attributes, gets a default FrameInfo with its size and, where
/// it has no alpha, A = 1.
Frame read_exr(const std::filesystem::path& file, const std::vector<std::string>& planes = {});

/// Reads attributes only; a foreign file is an InputError.
FrameInfo read_exr_info(const std::filesystem::path& file);

/// Throws InputError for a file that was cut or never finished: each row's place must be noted and lie within it. Reads
/// the header and a few bytes of every chunk, no pixels.
void require_whole_exr(const std::filesystem::path& file);

/// Decodes every channel of every part and keeps none; throws InputError where one is damaged. Takes the memory of a
/// few chunks, however large the picture is.
void check_exr_pixels(const std::filesystem::path& file);

/// A frame that was renamed, or is of another program's making, is the one that its file's name says, and as much
/// later.
void number_as_named(FrameInfo& info, std::int64_t index);

/// "frame.0007.exr"
std::string frame_file_name(std::int64_t index, const std::string& extension = "exr");

/// Writes `text` to `file` aside, syncs, renames. Shared by everything that must appear whole or not at all.
void write_file_atomically(const std::filesystem::path& file, const std::string& text);

/// Removes what killed writers left in `folder`; files that another process is writing now stay.
void remove_unfinished_files(const std::filesystem::path& folder);

/// What one sequence folder says of itself (manifest.json): the settings that every frame shares.
struct Manifest {
    /// Index, time and poses are those of the frame with the lowest index; a window's camera is window_shape.
    FrameInfo shared;
    std::vector<std::string> planes;
    std::string command;      ///< as typed, for the record
    std::string fingerprint;  ///< hash of everything that decides the pixels; a resume with another one is refused
    std::optional<bool> single_part{};  ///< layout of the frames' files; earlier sequences do not say
};

Manifest read_manifest(const std::filesystem::path& folder);
void write_manifest(const std::filesystem::path& folder, const Manifest& manifest);

/// Whether the frames of one folder belong together: they share camera, samples a pixel, seed and host. What these are
/// the manifest says, where there is one; else the first frame that is shown.
class OneRender {
public:
    explicit OneRender(const std::filesystem::path& folder);
    /// Throws InputError naming `file` and what is another one there.
    void require(const std::filesystem::path& file, const FrameInfo& info);

private:
    std::optional<FrameInfo> expected_;
    std::string as_in_ = "the frames before it";
};

/// How closely frames of two folders belong together. Each asks for all that stands before it, too.
enum class Companion {
    scene,  ///< scene, geometry and time
    head,   ///< the head's pose, and the distance between its eyes
    light,  ///< exposure and seed
    eye
};

/// What frames of this role must share with those of main that they are shown with. Both eyes of one video are of
/// main's role.
Companion companion_of(TrackRole role);

/// A layer of another render would fill gaps from the wrong place; so would another eye's. Throws InputError naming
/// `folder`, the frame and what is another one there than `main` of `main_folder` has. `hint`: what else to do.
void require_companion(Companion companion, const std::filesystem::path& main_folder, const FrameInfo& main,
                       const std::filesystem::path& folder, const FrameInfo& other, const std::string& hint);

/// Indices of the frames present, ascending. Unfinished (aside) files do not count.
std::vector<std::int64_t> list_frames(const std::filesystem::path& folder, const std::string& extension = "exr");

}  // namespace equistream
