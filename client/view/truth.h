#pragma once
/// Path-traced eyes of the path that is watched, to be seen beside what is drawn: a folder that `render --camera
/// perspective` wrote. Read when asked for, by whoever asks.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <equistream_client/receive.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace equistream {

/// One frame of it.
struct TrueEyes {
    std::int64_t index = -1;
    double time_s = 0, ipd_m = default_ipd_m;
    Pose head;
    PerspectiveCamera camera;
    std::array<ByteImage, 2> rgb;  ///< left and right; display-referred, 3 channels; empty: not rendered
};

class Truth {
public:
    /// Throws InputError where the folder has no perspective eyes, or their frames cannot be read.
    explicit Truth(const std::filesystem::path& folder);

    /// Of a frame of this time; null: there is none within half an interval. Until the next call. Throws as the
    /// constructor does.
    const TrueEyes* at(double time_s);
    /// Of the first frame.
    const PerspectiveCamera& camera() const { return camera_; }

private:
    bool read(std::size_t eye, std::int64_t index);

    std::filesystem::path folder_;
    std::array<std::unique_ptr<FrameFeed>, 2> feeds_;  ///< of an eye that was rendered
    PerspectiveCamera camera_;
    double first_s_ = 0, frames_per_second_ = 30;
    std::int64_t first_index_ = 0;
    TrueEyes eyes_;
};

}  // namespace equistream
