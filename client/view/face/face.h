#pragma once
/// The window's face: menu bar, panel, timeline, keys, times by stage, legends, and a line of what has to be said. Menu
/// bar and timeline are there while the pointer moves or the panel is shown. It is drawn over the picture and in no
/// picture that is kept. In the thread of the window's context, which is current in every call.
#include "content.h"
#include "gui.h"
#include "stage_graph.h"

#include <client/view/gl/eye_renderer.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

class Face {
public:
    /// Without the pointer's moving, until menu bar and timeline go.
    static constexpr double awake_s = 2.5;

    void resize(gl::Size window, double scale) { gui_.resize(window, scale); }
    /// What it says from now on.
    void say(FaceContent content);
    const FaceContent& content() const { return content_; }

    /// What happened, in its order.
    void feed(const InputEvent& event);
    bool has_pointer() const { return gui_.has_pointer(); }
    /// Keys and text are for it.
    bool has_keyboard() const { return gui_.has_keyboard() || asks_for_source_; }
    /// The same of one key: escape closes what is open.
    bool takes(const KeyEvent& key) const;
    /// Where the pointer is over the picture, in pixels of the window; nothing: over a panel, or nowhere.
    std::optional<PointerEvent> pointer_over_picture() const;
    /// What was asked for since the last call.
    std::vector<FaceWish> take_wishes() { return std::exchange(wishes_, {}); }

    /// The keys' first page, the next, or after the last none.
    void turn_help_page() { ++help_page_; }
    void ask_for_source();
    /// One refresh's times, told apart by stage; `refresh_ms` from the one before to it.
    void add(const gl::StageTimes::Row& row, double refresh_ms) { graph_.add(row, refresh_ms); }

    /// Whether menu bar and timeline are there, by now.
    bool is_awake() const;
    void draw();

private:
    struct Room {
        float top = 0, bottom = 0;  ///< what menu bar and timeline leave
    };

    void build();
    void build_menu_bar();
    void build_file_menu();
    void build_settings_menu(SettingMenu menu);
    void build_setting_menu(const ShownSetting& setting);
    void build_action(Action action, const char* label, bool is_chosen = false);
    void build_timeline();
    void build_bar();
    float build_panel(const Room& room);
    void build_section(PanelSection section);
    void build_setting(const ShownSetting& setting);
    void build_passes(const ShownSetting& setting);
    void build_help(const Room& room);
    void build_warning(float bottom);
    void build_loading();
    void build_source_field();
    void build_about();

    template <typename Wish>
    void wish(Wish wanted) {
        wishes_.emplace_back(std::move(wanted));
    }
    void choose(const ShownSetting& setting, std::string value);

    Gui gui_;
    FaceContent content_;
    std::vector<FaceWish> wishes_;
    StageGraph graph_;
    int help_page_ = 0;  ///< from 1; 0: none
    bool asks_for_source_ = false, shows_about_ = false;
    std::string source_text_;  ///< as it is typed
    std::optional<PointerEvent> pointer_;
    std::optional<double> sought_s_;  ///< by the drag along the timeline that goes on
    Clock::time_point moved_ = Clock::now();
};

}  // namespace equistream
