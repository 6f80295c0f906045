#pragma once
/// Where coded bytes go: a file that appears under its name only when it is finished, a device, or a URL. NAME.part is
/// locked while it is written, so that two processes never mix in it.
#include "libav.h"

#include <equistream/stream.h>

#include <cstddef>
#include <optional>
#include <string>

namespace equistream {

class Output {
public:
    /// Opens NAME.part for a path, the path itself for a device or pipe, or the URL; nothing for a tap that is alone.
    /// Throws InputError. Muxers go back to fill in how long something is: it must fit into so many bytes. Only in
    /// NAME.part without a tap they can go back farther.
    Output(const std::string& target, std::optional<StreamTap> tap, std::size_t max_header_bytes);
    ~Output();
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    AVIOContext* io() const { return io_; }
    /// Empty for what is not written aside.
    const std::string& unfinished_file() const { return aside_; }
    /// Hands everything over and syncs it; throws WorkError saying why it could not.
    void flush();
    /// flush, then the file gets its name.
    void finish();
    /// The operating system's reason for the first write that failed, or an empty string.
    std::string write_error() const;

private:
    static int write_bytes(void* self, std::uint8_t* bytes, int size);
    static std::int64_t go_to(void* self, std::int64_t offset, int whence);
    void open_aside();
    void make_io(std::size_t max_header_bytes);
    [[noreturn]] void fail() const;

    void write_to_file(const std::uint8_t* bytes, int size);

    std::string target_;
    std::optional<StreamTap> tap_;
    std::string aside_;
    AVIOContext* io_ = nullptr;
    int file_ = -1;
    int first_errno_ = 0;
    bool has_bytes_ = false;
};

// Which container a target's name asks for, and how it is written so that a cut file still plays.

struct Container {
    const char* muxer = nullptr;
    bool one_track = false;               ///< raw H.264 or H.265
    bool names_tracks = false;            ///< metadata of a track survive
    bool tags_spheres = false;            ///< what ordinary 360 players look for survives
    std::optional<Codec> only_for_codec;  ///< raw streams say their codec in their extension
};

/// Throws InputError listing the extensions that are known.
Container choose_container(const std::string& target);

}  // namespace equistream
