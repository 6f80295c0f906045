#pragma once
/// The viewer: the window and what happens to it in the main thread; what it shows in a thread of its own.
#include "input_box.h"
#include "viewer_settings.h"
#include "window.h"

#include <memory>
#include <vector>

namespace equistream {

class Viewer {
public:
    /// Opens a window. Throws InputError where that cannot be. In the main thread, as run() is.
    explicit Viewer(const ViewerSettings& settings);
    ~Viewer();

    /// Opens the source, and goes on until the window is closed. Throws what opening it threw.
    ViewerReport run();

private:
    void observe();
    void do_what_is_asked();
    void write_kept();
    HeldActions held() const;

    ViewerSettings settings_;
    KeptSettings kept_;                       ///< as they are to be written
    std::optional<DesktopPlace> asked_size_;  ///< of the window, by the command line; nothing: as it was kept
    KeptSettings written_;                    ///< as they were read or written last
    bool may_write_ = true;
    std::unique_ptr<Window> window_;
    InputBox box_;
    WindowInputs seen_;        ///< memory for observe()
    std::vector<int> chords_;  ///< keys that are down since they were pressed with another: not held for themselves
    HeldActions held_;         ///< these four as they were told last
    Sticks sticks_;
    gl::Size size_;
    double scale_ = 0;
};

}  // namespace equistream
