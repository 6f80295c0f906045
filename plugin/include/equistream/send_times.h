#pragma once
/// When the bytes of a recorded stream have to be sent, in their order, for its pictures to come in time.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace equistream {

struct DueBytes {
    std::int64_t end = 0;  ///< all bytes before this one, from the part before on
    double time_s = 0;     ///< are due now, counted from when the first picture is shown
};

struct DuePacket {
    std::int64_t start = 0;  ///< its place
    double time_s = 0;       ///< as those of `parts`, if all packets lay in the order in which they are decoded
};

struct SendTimes {
    /// Both numbers rise from part to part; the first one, due at 0, has the header, the last one ends with the file.
    std::vector<DueBytes> parts;
    /// By their places; of Matroska none, where packets lie in that order.
    std::vector<DuePacket> packets;
    double duration_s = 0;  ///< until the last picture has been shown for as long as the others; above 0
    /// Until the last picture is shown, of the track in which that takes longest: from its own first picture on.
    double longest_track_s = 0;
    bool is_matroska = false;
};

/// Reads the whole file once, without decoding. A packet is due when its picture is shown or, where one that is shown
/// earlier lies behind it in the file (pictures are coded in another order; an mp4 may have a group of one track, then
/// of the other), when that one is. Throws InputError for what is no video or does not say the times or places of its
/// packets. Once `interrupted`, which is asked now and then, says so, what was read until then counts as all.
SendTimes read_send_times(const std::string& file, const std::function<bool()>& interrupted = {});

}  // namespace equistream
