#pragma once
/// Send times of a recorded stream: when its bytes are due so that its pictures arrive in time.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace equistream {

/// A run of bytes that are due together: from the previous part's end to `end`.
struct DueBytes {
    std::int64_t end = 0;  ///< offset in the file of the first byte after the run
    double time_s = 0;     ///< due time; 0 is when the first picture is shown
};

/// One packet, sent in the order of decoding instead of the file's order.
struct DuePacket {
    std::int64_t start = 0;  ///< offset in the file
    double time_s = 0;       ///< due time; 0 is when the first picture of its own track is shown
};

/// The packets of one time, which follow each other in a Matroska file.
struct Moment {
    std::int64_t after = 0;     ///< offset in the file of the packet before
    std::int64_t start = 0;     ///< offset of its first packet
    double time_s = 0;          ///< when that is due; 0 is when the first picture is shown
    bool begins_group = false;  ///< from here on, every track can be decoded without what comes before
};

struct SendTimes {
    /// Ends and times ascend. The first part holds the header and is due at 0; the last one ends at the file's end.
    std::vector<DueBytes> parts;
    /// In ascending order of `start`; empty for Matroska, which stores packets in the order of decoding.
    std::vector<DuePacket> packets;
    /// In their order, without the first; empty for all but Matroska.
    std::vector<Moment> moments;
    double duration_s = 0;  ///< from the first picture to the end of the last, each shown for 1 / frame rate; above 0
    /// From the first to the last picture of the longest track.
    double longest_track_s = 0;
    bool is_matroska = false;
};

/// The last of `moments` that begins a group and is due by then; null: none.
const Moment* newest_group(const std::vector<Moment>& moments, double by_s);

/// Reads the whole file once, without decoding. A packet is due when its picture is shown, or earlier: no packet is due
/// later than one behind it in the file. (Pictures are coded in another order, and an mp4 may store a group of one
/// track before that of the next.) Throws InputError for a file that is no video, or whose packets have no times or
/// offsets. Calls `interrupted` now and then; once it returns true, the packets read so far count as the whole file.
SendTimes read_send_times(const std::string& file, const std::function<bool()>& interrupted = {});

}  // namespace equistream
