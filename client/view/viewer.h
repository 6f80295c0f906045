#pragma once
/// The viewer: the window and what happens to it in the main thread; what it shows in a thread of its own.
#include "input_box.h"
#include "presenter.h"
#include "truth.h"
#include "window.h"

#include <client/playback/frame_loader.h>

#include <memory>
#include <optional>
#include <vector>

namespace equistream {

class Viewer {
public:
    /// Opens the source first and then a window. Throws InputError for either. In the main thread, as run() is.
    explicit Viewer(const ViewerSettings& settings);
    ~Viewer();

    /// Until the window is closed.
    ViewerReport run();

private:
    void observe();
    HeldActions held() const;

    std::optional<Truth> truth_;
    PoseSender poses_;
    std::unique_ptr<Window> window_;
    std::shared_ptr<gl::PictureBuffers> pictures_;  ///< in the window's context; null: pictures are copied
    FrameLoader loader_;                            ///< writes into them
    InputBox box_;
    std::unique_ptr<Presenter> presenter_;
    TakenInputs seen_;         ///< memory for observe()
    std::vector<int> chords_;  ///< keys that are down since they were pressed with another: not held for themselves
    HeldActions held_;         ///< these three as they were told last
    Sticks sticks_;
    gl::Size size_;
};

}  // namespace equistream
