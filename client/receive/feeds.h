#pragma once
/// The feeds behind open_feed.
#include "receive.h"

#include <cstddef>

namespace equistream {

std::unique_ptr<FrameFeed> open_folder_feed(const std::string& folder, const FeedOptions& options);
/// `max_held_bytes`: of pictures that wait for others of their frame, beyond a few frames' own.
std::unique_ptr<FrameFeed> open_stream_feed(const std::string& source, const FeedOptions& options,
                                            std::size_t max_held_bytes = std::size_t{512} << 20);
/// Nothing where nobody says.
inline TrackRoles asked_to_leave_out(const FeedOptions& options) {
    return options.left_out ? options.left_out() : TrackRoles{};
}

/// Throws WorkError unless the frame's patches, where it has some, are of a sphere as its main picture is: the client
/// allocates and looks up by that sphere's size.
void require_patches_of_main(const std::string& source, const ReceivedFrame& frame);

/// Makes the window the frame's main picture, and what was that its base. Throws WorkError unless both are parts of
/// one sphere.
void look_through_window(const std::string& source, ReceivedPicture window, ReceivedFrame& frame);

}  // namespace equistream
