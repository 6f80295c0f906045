#pragma once
/// Opening what is to be read: a file or URL, treated as hostile.
#include "libav.h"

#include <equistream/stream.h>

#include <memory>
#include <string>

namespace equistream {

/// What is read, and by what. One object, one place in memory: libav keeps its address.
class Source {
public:
    /// Throws InputError for what is no video; playlists are refused. Of `options`, which must outlive it, only
    /// `interrupted` and `read` are used.
    Source(const std::string& name, const StreamReadOptions& options);
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    AVFormatContext* operator->() const { return format_.get(); }
    AVFormatContext& operator*() const { return *format_; }
    AVFormatContext* get() const { return format_.get(); }

private:
    struct FreeIo {
        void operator()(AVIOContext* io) const {
            av_freep(&io->buffer);
            avio_context_free(&io);
        }
    };
    std::unique_ptr<AVIOContext, FreeIo> io_;  ///< where bytes are read by a function; outlives the demuxer
    av::Demuxer format_;
};

}  // namespace equistream
