#pragma once
/// A recorded stream of tiles (window.h, TrackRole::window), sent to each viewer without the tiles that it does not
/// look at. All others of the stream's tracks are sent whole. A tile that comes into view begins with its last key
/// frame, so that it is sharp with the next frame.
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

/// What a file of tiles holds. Plain values; copies share nothing.
struct TileRecording {
    std::string file;
    TileGrid grid;
    FrameInfo first;                        ///< main's first frame: where the head was, and the sphere's axes
    std::vector<std::optional<int>> tiles;  ///< of each of the file's tracks, its tile; nothing: it has none
    SendTimes times;                        ///< when its bytes are due
};

/// Decodes the first picture of each track; nothing where the file is a stream without tiles. Throws InputError naming
/// the file where it is no stream, or its tiles are not the parts of one sphere. Ends early, with less than all times,
/// where `interrupted` says so, and throws InputError where too little was read by then.
std::optional<TileRecording> open_tiles(const std::string& file, const std::function<bool()>& interrupted = {});

/// What one viewer is sent, as Matroska. One object, one thread.
class TileSender {
public:
    /// Throws InputError where the file has gone.
    explicit TileSender(const TileRecording& recording);
    ~TileSender();
    TileSender(const TileSender&) = delete;
    TileSender& operator=(const TileSender&) = delete;

    /// When the next bytes are due, in seconds from the first; nothing: all has been sent.
    std::optional<double> due_s() const;
    /// Appends what is due next: first the header, then one moment's pictures, of tiles only those that are looked at.
    /// The first moment's are all sent, by which whoever reads knows each track. Throws WorkError where the file cannot
    /// be read on.
    void next(const std::set<int>& looked_at, std::string& bytes);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
