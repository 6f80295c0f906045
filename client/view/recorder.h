#pragma once
/// What a viewer keeps: single pictures, the view as numbered pictures, and the head's path as CSV (docs/scenes.md,
/// "Paths"), which play and render take. Nothing that is there is written over: names count up.
#include <equistream/camera.h>
#include <equistream/image.h>
#include <scenes/library/scene.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

class Recorder {
public:
    explicit Recorder(std::filesystem::path folder) : folder_(std::move(folder)) {}
    /// A path that is being recorded is written as far as it came; a failure then is told on stderr.
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// All say in one line what they did. Throw InputError or WorkError where a file cannot be written.
    std::string keep_picture(ImageView<const std::uint8_t> rgb);
    std::string start_or_stop_view();
    std::string start_or_stop_head();

    bool records_view() const { return !view_folder_.empty(); }
    bool records_head() const { return records_head_; }
    /// One refresh; does nothing unless it is being recorded. A picture that cannot be written ends the recording.
    void add_view(ImageView<const std::uint8_t> rgb);
    /// `time_s` is the source's: play and render put the head there again. While it stands still or goes back nothing
    /// is added.
    void add_head(double time_s, const Pose& head);

private:
    std::filesystem::path folder_, view_folder_;
    std::int64_t view_pictures_ = 0;
    bool records_head_ = false;
    std::vector<PosePath::Key> head_;
};

}  // namespace equistream
