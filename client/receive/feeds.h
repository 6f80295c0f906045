#pragma once
/// The feeds behind open_feed.
#include <equistream_client/receive.h>

namespace equistream {

std::unique_ptr<FrameFeed> open_folder_feed(const std::string& folder, const FeedOptions& options);
std::unique_ptr<FrameFeed> open_stream_feed(const std::string& source, const FeedOptions& options);
/// Nothing where nobody says.
inline TrackRoles asked_to_leave_out(const FeedOptions& options) {
    return options.left_out ? options.left_out() : TrackRoles{};
}

/// Either of them, FeedOptions::frames_ahead of who asks.
std::unique_ptr<FrameFeed> open_feed_ahead(const std::string& source, const FeedOptions& options);

}  // namespace equistream
