#include "feeds.h"

#include <equistream/error.h>

#include <filesystem>

namespace equistream {

std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options) {
    if (options.frames_ahead > 0)
        return open_feed_ahead(source, options);
    std::error_code ignored;
    if (std::filesystem::is_directory(source, ignored)) {
        if (options.hdr_display)
            throw InputError(expected_found(source, "an HDR stream, for a display, a view or an exposure to be chosen",
                                            "a folder of frames"));
        return open_folder_feed(source, options);
    }
    return open_stream_feed(source, options);
}

}  // namespace equistream
