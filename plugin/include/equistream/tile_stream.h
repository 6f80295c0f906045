#pragma once
/// Serving a recorded stream of tiles (window.h, TrackRole::window): each viewer gets only the tiles in its view. All
/// other tracks are sent whole. A tile that comes into view is sent from its last key frame on, so that it is sharp
/// with the next frame.
#include <equistream/frame.h>
#include <equistream/send_times.h>
#include <equistream/window.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace equistream {

/// Content of a file of tiles. A plain value.
struct TileRecording {
    std::string file;
    TileGrid grid;
    FrameInfo first;                        ///< main's first frame: head, sphere and axes
    std::vector<std::optional<int>> tiles;  ///< number of each track's tile, by track; nullopt: the track is no tile
    SendTimes times;                        ///< when the file's bytes are due
};

/// Reads the file once and decodes the first picture of each track. nullopt for a stream without tiles. Throws
/// InputError naming the file if it is no stream, or its tiles are not the parts of one sphere. Once `interrupted`
/// returns true, the call ends early with the send times read so far, or throws InputError if it has read too little.
std::optional<TileRecording> open_tiles(const std::string& file, const std::function<bool()>& interrupted = {});

/// Produces the Matroska stream for one viewer. One object, one thread.
class TileSender {
public:
    /// `recording` outlives the object. Throws InputError if the file cannot be opened.
    explicit TileSender(const TileRecording& recording);
    ~TileSender();
    TileSender(const TileSender&) = delete;
    TileSender& operator=(const TileSender&) = delete;

    /// When the next bytes are due, in seconds from the first; nullopt: everything has been sent.
    std::optional<double> due_s() const;
    /// Appends to `bytes` what is due next: at first the header, then the pictures of one moment at a time. Of the
    /// tiles it sends only the numbers in `looked_at`, except at the first moment: then all, so that readers know every
    /// track. Throws WorkError if libav cannot write the stream.
    void next(const std::set<int>& looked_at, std::string& bytes);
    /// Leaves out what comes before the last group of pictures that is due by `time_s`, if that has not begun. Does
    /// nothing before the header was sent, and for files that are no Matroska.
    void skip_to_group(double time_s);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
