#pragma once
/// What the displaying thread does from the window's opening to its end: it opens sources, shows one of them, and hands
/// inputs to the face and to the picture.
#include "face/face.h"
#include "input_box.h"
#include "input_router.h"
#include "presenter.h"
#include "viewer_settings.h"
#include "watched_source.h"
#include "window.h"

#include <client/view/xr/headset.h>

#include <memory>
#include <optional>
#include <string>

namespace equistream {

class DisplayLoop {
public:
    /// In the thread in which the window's context is current, as all calls are. Throws InputError where a headset is
    /// wanted and there is none.
    DisplayLoop(const ViewerSettings& settings, InputBox& box, Window& window);
    DisplayLoop(const DisplayLoop&) = delete;
    DisplayLoop& operator=(const DisplayLoop&) = delete;

    /// Until the window is closed, or it was told to end. Without a source the window waits for one. Throws what
    /// opening the command line's source threw; what opening another one throws is said in the window, and the one
    /// before goes on.
    void run();
    /// Of the source that was shown last.
    ViewerReport report();

private:
    void open(ViewerSettings settings);
    void open_other(const std::string& source);
    void finish_opening();
    void show(std::unique_ptr<WatchedSource> source);
    void take_inputs();
    void grant(const FaceWish& wish);
    void grant_wishes();
    void choose(const SettingWish& chosen);
    void act_without_picture();
    void draw_without_picture();
    void keep_changes();
    void ask_for_more();
    bool is_over() const;

    ViewerSettings settings_;
    InputBox& box_;
    Window& window_;
    std::unique_ptr<Headset> headset_;  ///< null: the window alone shows what there is
    Face face_;
    InputRouter router_;
    WindowInputs window_inputs_;
    ViewInputs inputs_;
    std::unique_ptr<SourceOpening> opening_;
    std::string problem_;   ///< why the last one could not be opened, where no other is shown
    bool is_first_ = true;  ///< it is the command line's
    bool resumes_ = false;  ///< it goes on where the one that is shown is
    ShownSettings shown_;   ///< as it was last
    KeptSettings kept_;
    std::unique_ptr<WatchedSource> source_;
    std::unique_ptr<Presenter> presenter_;  ///< null: no source was opened yet; gone before its source
    std::optional<Clock::time_point> began_;
    bool quit_ = false, may_reopen_ = true, is_drawn_ = false;
};

}  // namespace equistream
