#pragma once
/// Path-traced eyes of the path that is watched, to be seen beside what is drawn: a folder that `render --camera
/// perspective` wrote. Read by a thread of its own, the eye that is asked for and a few frames ahead of it: who
/// displays never waits for one.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <client/receive/receive.h>

#include <array>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace equistream {

/// Of one frame.
struct TrueEye {
    double time_s = 0, ipd_m = default_ipd_m;
    Pose head;
    PerspectiveCamera camera;
    ByteImage rgb;  ///< display-referred, 3 channels
};

class Truth {
public:
    struct Found {
        std::shared_ptr<const TrueEye> eye;  ///< null: it is none of the folder's, not read yet, or cannot be read
        bool is_coming = false;              ///< it is being read
        std::string problem;                 ///< why it cannot be read; empty: it can, or is not there
    };

    /// Reads the first frame. Throws InputError where the folder has no perspective eyes, or that cannot be read.
    explicit Truth(const std::filesystem::path& folder);
    ~Truth();
    Truth(const Truth&) = delete;
    Truth& operator=(const Truth&) = delete;

    /// Of the first frame.
    const PerspectiveCamera& camera() const { return camera_; }
    /// Of the frame within half an interval of this time, from now on read ahead of all others. One thread.
    Found at(double time_s, Eye eye);

private:
    static constexpr std::int64_t frames_ahead = 3;

    using Place = std::pair<std::size_t, std::int64_t>;  ///< eye and number of the frame
    struct Slot {
        std::shared_ptr<const TrueEye> eye;
        std::string problem;
    };
    bool is_wanted(const Place& place) const;
    std::optional<Place> next_to_read() const;
    std::shared_ptr<const TrueEye> read(const Place& place);
    void run();

    std::filesystem::path folder_;
    std::array<std::unique_ptr<FrameFeed>, 2> feeds_;  ///< of an eye that was rendered; the reading thread's
    PerspectiveCamera camera_;
    double first_s_ = 0, frames_per_second_ = 30;
    std::int64_t first_index_ = 0;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::map<Place, Slot> read_;
    Place wanted_;
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace equistream
