#pragma once
/// A stream or folder as a viewer watches it, and how it is opened while the window is there already.
#include "truth.h"
#include "viewer_settings.h"

#include <client/gpu/context.h>
#include <client/playback/frame_loader.h>
#include <client/warp/gl/picture_buffers.h>

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

namespace equistream {

/// How long a file is whose container does not say it: found by a thread that reads all of it, behind what is played.
class LengthFinder {
public:
    /// `frame_s`: for which the last frame is shown.
    LengthFinder(const std::string& file, double frame_s);
    ~LengthFinder();
    LengthFinder(const LengthFinder&) = delete;
    LengthFinder& operator=(const LengthFinder&) = delete;

    /// From the first frame to the end of the last; 0: not known, or not yet.
    double seconds() const { return seconds_; }

private:
    std::atomic<bool> stopping_ = false;
    std::atomic<double> seconds_ = 0;
    std::thread thread_;
};

/// Opened when it is made, by any thread. Destroyed where the context is current in which its buffers were read.
class WatchedSource {
public:
    /// Throws InputError as FrameLoader and Truth do, and where the frames were rendered from other geometry than the
    /// scene's. `interrupted` ends it early.
    WatchedSource(const ViewerSettings& settings, std::function<bool()> interrupted);

    const ViewerSettings settings;
    std::optional<Truth> truth;
    PoseSender poses;
    std::shared_ptr<gl::PictureBuffers> pictures;  ///< null: pictures are copied
    FrameLoader loader;                            ///< writes into them
    std::string note;                              ///< on geometry that could not be checked; else empty

    /// From the first frame to the end of the last; 0: not known, or not yet.
    double seconds() const;

private:
    std::optional<LengthFinder> length_;
};

/// Whether what is to be shown now needs more of the source than was asked for when it was opened.
bool needs_reopening(const ViewerSettings& opened, const ShownSettings& shown);

/// Opens a source in a thread of its own.
class SourceOpening {
public:
    /// `done` is called by that thread, once.
    SourceOpening(const ViewerSettings& settings, const std::function<void()>& done);
    /// Gives it up where it is not done.
    ~SourceOpening();
    SourceOpening(const SourceOpening&) = delete;
    SourceOpening& operator=(const SourceOpening&) = delete;

    /// For people: without a secret.
    const std::string& name() const { return name_; }
    bool is_done() const { return done_; }
    /// Once it is done. Throws what opening threw.
    std::unique_ptr<WatchedSource> take();

private:
    std::string name_;
    std::shared_ptr<std::atomic<bool>> stopping_ = std::make_shared<std::atomic<bool>>(false);  ///< outlives this
    std::atomic<bool> done_ = false;
    std::unique_ptr<WatchedSource> source_;
    std::exception_ptr failure_;
    std::thread thread_;  // last: it begins when all else is there
};

}  // namespace equistream
