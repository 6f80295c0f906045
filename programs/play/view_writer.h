#pragma once
/// Finished views to files: pictures, linear EXRs, or a video, of each eye or of both in one; and gap masks.
#include "settings.h"

#include <client/warp/view.h>
#include <equistream/frame.h>

#include <memory>

namespace equistream::play {

/// One eye's view with all that goes into its file.
struct FinishedView {
    const EyePicture& picture;
    ImageView<const float> depth_m;  ///< the eye's depth where it was cast; else empty
    FrameInfo info;                  ///< camera, pose and eye are this view's
};

/// One eye's views.
class ViewWriter {
public:
    virtual ~ViewWriter() = default;
    virtual void write(const FinishedView& view) = 0;
    /// Ends a video; nothing to do for pictures.
    virtual void finish() = 0;
    virtual std::int64_t bytes() const = 0;
};

/// By the format: OUT/EYE/frame.NNNN.png or .exr, or OUT/EYE.mp4. Creates the folder; throws InputError if it cannot.
std::unique_ptr<ViewWriter> make_view_writer(const Settings& settings, const std::string& eye);

/// Both eyes' views.
class EyesWriter {
public:
    virtual ~EyesWriter() = default;
    virtual void write(const FinishedView& left, const FinishedView& right) = 0;
    /// Everything that can be, also if something cannot.
    virtual void finish() = 0;
    virtual std::int64_t bytes() const = 0;
};

/// By the layout: make_view_writer's of left and right; or one picture that holds both, OUT/both/frame.NNNN.png or
/// OUT/both.mp4, or OUT itself where that is a video. Throws as that does.
std::unique_ptr<EyesWriter> make_eyes_writer(const Settings& settings);

}  // namespace equistream::play
