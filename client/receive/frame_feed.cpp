#include "feeds.h"

#include <client/warp/engine.h>
#include <equistream/error.h>
#include <equistream/formatted.h>

#include <filesystem>

namespace equistream {

void require_patches_of_main(const std::string& source, const ReceivedFrame& frame) {
    if (!frame.patches || !frame.patches->info.patches)
        return;
    const Camera sphere = frame.patches->info.patches->sphere();
    const ReceivedPicture& main = frame.main;
    if (same_camera(sphere, main.info.camera) && main.width() == width_of(sphere) && main.height() == height_of(sphere))
        return;
    const bool same_size = main.width() == width_of(sphere) && main.height() == height_of(sphere);
    throw WorkError(expected_found(source + ": frame " + std::to_string(main.info.index) + " of patches",
                                   "the sphere of its main picture, " + size_text(main.width(), main.height()),
                                   same_size ? "another range" : size_text(width_of(sphere), height_of(sphere))));
}

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
