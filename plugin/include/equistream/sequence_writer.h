#pragma once
/// Writes a sequence folder: frames, manifest, and the rules for adding to a folder that has frames already. Every host
/// that renders and every program that makes frames of files goes through it. One object, one thread.
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
    Manifest manifest;  ///< all that frames share; the fingerprint covers every setting that decides pixels
    bool overwrite = false;
    bool single_part = false;
    FramePart part{};   ///< one of several is written into a folder of its own in `folder`
    int tile_side = 0;  ///< of parts: pixels, the same for all
    /// Of every file, as ExrWriteOptions::texts.
    std::vector<std::pair<std::string, std::string>> texts{};
};

/// A name for everything in the manifest that decides pixels, and for what else the host says does.
std::string sequence_fingerprint(const Manifest& manifest, const std::string& of_host);

/// How two manifests differ in what decides pixels or the files' layout: "expected spp 16, found 64"; nothing if they
/// agree.
std::optional<std::string> difference(const Manifest& expected, const Manifest& found);

/// An open sequence. A folder belongs to one at a time, of this process or any other.
class SequenceWriter {
public:
    /// Makes or resumes the folder and holds it; throws InputError when it cannot be used, holds other frames or is
    /// held by another sequence.
    explicit SequenceWriter(SequenceSettings settings);

    const Manifest& manifest() const { return settings_.manifest; }
    /// Where a frame is, once it is written. Any thread.
    std::filesystem::path frame_file(std::int64_t index) const { return settings_.folder / frame_file_name(index); }
    const FramePart& part() const { return settings_.part; }
    /// Whether the folder has this frame, whole, and it stays. One that was cut or is empty counts as not there, and so
    /// does a part that was changed. A part is also kept where the frame it was for has been put together.
    bool keeps_frame(std::int64_t index) const;
    /// Writes a finished frame; the manifest takes its poses from the one with the lowest index, whenever it comes.
    void write(const Frame& frame, std::int64_t left_out_samples = 0);

    /// Of one part: writes what its tiles brought.
    void write_part(const FrameInfo& info, const std::string& bytes);
    /// Of frames that are put together: what part `number` brought to a frame, `size` bytes. Throws InputError where it
    /// is missing, was cut or changed, or is of other settings.
    std::string read_part(std::int64_t index, std::uint32_t number, std::size_t size) const;
    /// Of frames that are put together, once this one is written: its parts go, and folders with no other that nobody
    /// renders into.
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
    bool knows_first_frame_ = false;      // the manifest's index, time and poses are those of a frame in the folder
    bool manifest_is_current_ = false;    // the one in the folder is ours
};

}  // namespace equistream
