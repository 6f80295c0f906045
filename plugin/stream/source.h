#pragma once
/// Opening what is to be read: a file or URL, treated as hostile.
#include "libav.h"
#include "pipe.h"

#include <equistream/elapsed.h>
#include <equistream/stream.h>

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace equistream {

/// What is read, and by what. One object, one place in memory: libav keeps its address.
class Source {
public:
    /// Throws InputError for what is no video, and WorkError for a server that does not answer; playlists are refused.
    /// Of `options`, which must outlive it, only `interrupted` and `read` are used. `patience` holds for addresses that
    /// are opened here; `read` has its own.
    /// `is_copied`: packets are passed on, not decoded.
    Source(const std::string& name, const StreamReadOptions& options, const Patience& patience = {},
           bool is_copied = false);
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    AVFormatContext* operator->() const { return format_.get(); }
    AVFormatContext& operator*() const { return *format_; }
    AVFormatContext* get() const { return format_.get(); }

    /// Before bytes are asked for: patience begins anew.
    void begin_waiting() { waiting_since_ = Clock::now(); }
    /// Why no more bytes come, where that is no ordinary end: the server is silent, or what `read` threw.
    const std::string& problem() const { return problem_; }

private:
    static int answer_interrupt(void* self);
    static int read_bytes(void* self, std::uint8_t* bytes, int size);
    bool is_to_give_up();
    void make_io();
    void open(const std::string& name);

    std::unique_ptr<Pipe> pipe_;  ///< null: it is none, or is read by a function
    av::Io io_;                   ///< where bytes are read by a function or from a pipe; outlives the demuxer
    av::Demuxer format_;
    const StreamReadOptions& options_;
    Patience patience_;
    bool is_watched_;  ///< opened here, from a server
    bool is_copied_;
    Clock::time_point waiting_since_ = Clock::now();
    const AVFormatContext* opening_ = nullptr;  ///< what libav works on
    std::int64_t bytes_ = -1;                   ///< that had come when it was asked last; -1: not connected
    std::string problem_;
};

/// Whether several tracks are called windows, which are tiles: by names alone, before anything is decoded.
bool has_tiles(const AVFormatContext& format);

// Where to begin decoding so that a moment can be shown: the packets from there on.

/// Of these streams, the first of which decides what is near, all packets in the order they lie in from each one's last
/// key frame on that is shown at `time_s` or before, as far as the search had to read; what follows comes next from
/// `format`. Nothing where that cannot be told (no times, no way back): `format` is anywhere then.
std::optional<std::deque<av::Packet>> find_packets(AVFormatContext& format, std::span<const int> streams,
                                                   double time_s);

}  // namespace equistream
