#pragma once
/// Finished views to files: pictures, linear EXRs, or a video, of each eye or of both in one.
#include "settings.h"

#include <client/warp/view.h>
#include <equistream/frame.h>
#include <equistream/stream.h>

#include <memory>
#include <vector>

namespace equistream::play {

/// One eye's view with all that goes into its file.
struct FinishedView {
    const EyePicture& picture;
    ImageView<const float> depth_m;  ///< the eye's depth where it was cast; else empty
    FrameInfo info;                  ///< camera, pose and eye are this view's
};

/// The views of one eye, or both eyes' in one picture.
class ViewWriter {
public:
    /// By the format: OUT/NAME/frame.NNNN.png or .exr, or OUT/NAME.mp4, or OUT itself where that is a video. Creates
    /// the folder; throws InputError if it cannot.
    ViewWriter(const Settings& settings, const std::string& name);

    void write(const FinishedView& view);
    /// Display-referred; not of EXRs.
    void write(ImageView<const std::uint8_t> rgb, const FrameInfo& info);
    /// Ends a video; nothing to do for pictures.
    void finish();
    std::int64_t bytes() const { return video_ ? video_->bytes().front() : bytes_of_pictures_; }

private:
    Format format_;
    Layout layout_;
    std::filesystem::path path_;
    std::optional<DisplayTransform> display_;  ///< for EXRs
    std::unique_ptr<StreamWriter> video_;      ///< once there is a first view
    std::int64_t bytes_of_pictures_ = 0;
};

/// Both eyes' views, by the layout: left and right; or one picture that holds both, called both.
class EyesWriter {
public:
    /// Throws as ViewWriter.
    explicit EyesWriter(const Settings& settings);

    void write(const FinishedView& left, const FinishedView& right);
    /// Everything that can be, also if something cannot.
    void finish();
    std::int64_t bytes() const;

private:
    const Anaglyph* anaglyph_;       ///< null: side by side, where both are in one
    std::vector<ViewWriter> views_;  ///< left and right, or both
};

}  // namespace equistream::play
