#pragma once
/// Writes a sequence folder: frames, manifest, and the rules for a folder that has frames already. All hosts and
/// importers use it. One object, one thread.
#include <equistream/frame.h>
#include <equistream/frame_part.h>
#include <equistream/locks.h>
#include <equistream/sequence.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

struct SequenceSettings {
    std::filesystem::path folder;
    Manifest manifest;         ///< settings of all frames; its fingerprint covers every setting that decides pixels
    bool overwrite = false;    ///< true: finished frames are replaced, of other settings too; false: they are kept
    bool single_part = false;  ///< ExrWriteOptions::single_part
    FramePart part{};          ///< a single part is written to a subfolder of `folder`
    int tile_side = 0;         ///< with parts: pixels, the same for all parts
    /// ExrWriteOptions::texts of every file.
    std::vector<std::pair<std::string, std::string>> texts{};
};

/// Hash (64-bit FNV-1a, hexadecimal) of all settings in the manifest that decide pixels, and of `of_host`, the host's
/// own fingerprint.
std::string sequence_fingerprint(const Manifest& manifest, const std::string& of_host);

/// The first difference of two manifests in the settings that decide pixels or the files' layout, such as "expected spp
/// 16, found 64"; nullopt if they agree.
std::optional<std::string> difference(const Manifest& expected, const Manifest& found);

/// An open sequence. A folder belongs to one at a time, of this process or any other.
class SequenceWriter {
public:
    /// Creates or resumes the folder, and locks it while the object lives. Throws InputError if the folder cannot be
    /// used, has frames of other settings (unless `overwrite`), or is locked by another sequence.
    explicit SequenceWriter(SequenceSettings settings);

    const Manifest& manifest() const { return settings_.manifest; }
    /// Path of a frame's file, written or not. Any thread.
    std::filesystem::path frame_file(std::int64_t index) const { return settings_.folder / frame_file_name(index); }
    const FramePart& part() const { return settings_.part; }
    /// Whether the folder has this frame complete, and it is not to be overwritten. A cut or empty file does not count,
    /// nor does a changed part. A part also counts as kept when its whole frame has been assembled.
    bool keeps_frame(std::int64_t index) const;
    /// Writes a finished frame. The manifest takes its time and poses from the frame with the lowest index, in whatever
    /// order frames are written. `left_out_samples` is ExrWriteOptions'.
    void write(const Frame& frame, std::int64_t left_out_samples = 0);

    /// A single part: writes the sums of its tiles (Film::part_bytes).
    void write_part(const FrameInfo& info, const std::string& bytes);
    /// Assembling frames: the `size` bytes of part `number` of a frame. Throws InputError if the part is missing, cut,
    /// changed, or of other settings.
    std::string read_part(std::int64_t index, std::uint32_t number, std::size_t size) const;
    /// Assembling frames, after write(): removes the frame's parts, and part folders that are empty and not in use.
    void remove_parts(std::int64_t index) const;

private:
    bool has_part(std::int64_t index) const;
    std::filesystem::path part_folder(std::uint32_t number) const;
    std::string part_heading(std::int64_t index, std::uint32_t number, std::uint64_t bytes,
                             std::uint32_t checksum) const;
    const char* extension() const { return settings_.part.is_one() ? "part" : "exr"; }
    void make_way_for(const FrameInfo& info);
    void set_first_frame(const FrameInfo& first);
    void make_folder() const;
    void refuse_other_whole_frames() const;
    void adopt_or_refuse();

    SequenceSettings settings_;
    std::optional<FolderLock> lock_;      // two renders at once would mix their settings
    std::vector<std::int64_t> outdated_;  // frames of other settings, to be overwritten
    bool knows_first_frame_ = false;      // the manifest's index, time and poses belong to a frame in the folder
    bool manifest_is_current_ = false;    // the folder's manifest.json equals settings_.manifest
};

}  // namespace equistream
